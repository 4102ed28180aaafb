# What vehicle uses of llvmlite.

__version__: str
