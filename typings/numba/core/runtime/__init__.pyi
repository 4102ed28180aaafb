from numba.core.cpu import CPUContext

class Runtime:
    def initialize(self, ctx: CPUContext) -> None: ...

rtsys: Runtime
