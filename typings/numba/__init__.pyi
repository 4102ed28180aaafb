# What vehicle uses of numba, which carries no types; most of it is not documented.
# tests/vehicle/test_linking.py holds it against the installed package.

__version__: str
