# What vehicle.linking uses of llvmlite.

__version__: str
