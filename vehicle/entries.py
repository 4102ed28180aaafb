"""A function as numba's dispatchers call it: from compiled code, from Python, or from compiled code by its address."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import FunctionType
from typing import Final

import llvmlite
import numba
import numpy as np
from numba.core import compiler, config, registry, serialize, types, typing
from numba.core.cpu import CPUContext
from numba.core.runtime import rtsys

from network.code_store import CodeStore
from vehicle import lazy_binding, linking
from vehicle.code_key import Reached, key_of, type_text
from vehicle.compiling import begin_piece, note_written
from vehicle.lazy_binding import Types

# The compiler, as far as code depends on it; these files belong to it.
COMPILER: Final = (
    numba.__version__,
    llvmlite.__version__,
    sys.implementation.cache_tag,
    ".".join(np.__version__.split(".")[:2]),
    [Path(file).read_bytes() for file in (__file__, linking.__file__, lazy_binding.__file__)],
)
SETTINGS: Final = ("OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "BOUNDSCHECK", "USING_SVML")
NO_NAMES: Final[dict[str, types.Type]] = {}
GENERIC: Final = ("generic", "")  # any processor of the architecture, and its features


class Inner(registry.CPUDispatcher):
    """One function as compiled code calls it."""

    all: Final[dict[FunctionType, Inner]] = {}

    def __init__(self, function: FunctionType, options: Mapping[str, object]) -> None:
        super().__init__(function, {}, options, pipeline_class=linking.InnerCompiler)
        self._key = ""
        self.all[function] = self

    def renew(self) -> None:
        """Forget what was compiled from something else, such as another value of a constant."""
        key = key_of(self.py_func)
        if key != self._key:
            self.overloads.clear()
            self._key = key

    def get_call_template(self, args: Types, kws: dict[str, types.Type]) -> object:
        """What callers are typed by; a constant as argument is a number like others, not a function of its own."""
        return super().get_call_template(*_plain(args, kws))

    def add_overload(self, cres: compiler.CompileResult) -> None:
        """Keep it for callers; there is nothing that Python could call."""
        self.overloads[tuple(cres.signature.args)] = cres
        note_written(self.py_func)


class Entry(registry.CPUDispatcher):
    """One function as Python calls it; compiled code that calls it gets the inner one."""

    def __init__(self, function: FunctionType, options: Mapping[str, object], store: CodeStore) -> None:
        super().__init__(function, {}, options, pipeline_class=linking.EntryCompiler)
        self.inner = Inner(function, options)
        self._cache = StoredCode(self, store)

    def compile(self, sig: Types) -> object:
        """Its machine code for these types of arguments; two processes that need it make it once."""
        with ExitStack() as alone:
            self._cache.alone = alone
            return super().compile(sig)

    def get_call_template(self, args: Types, kws: dict[str, types.Type]) -> object:
        """What compiled code that calls it is typed by."""
        return self.inner.get_call_template(args, kws)

    def get_overload(self, sig: Types) -> object:
        """What compiled code that calls it is linked with."""
        return self.inner.get_overload(sig)


class LateEntry(Entry):
    """One function as Python calls it, and as compiled code calls it by address."""

    def __init__(self, function: FunctionType, options: Mapping[str, object], store: CodeStore) -> None:
        super().__init__(function, options, store)
        self._stubs: dict[Types, object] = {}
        self.late = lazy_binding.LateFunction(function, self._address)

    @property
    def reached_as(self) -> str:
        """All that the code of its callers depends on."""
        return f"{self.late.name} -> {self.late.returns}"

    def get_call_template(self, args: Types, kws: dict[str, types.Type]) -> object:
        """What callers are typed by; of the function itself nothing is looked at."""
        pysig, folded = self.fold_argument_types(*_plain(args, kws))
        given = tuple(folded)
        if given not in self._stubs:
            self._stubs[given] = lazy_binding.stub_for(self.late, given, self.targetctx)
        signatures = [self.late.returns(*given)]
        template = typing.make_concrete_template("Stub", self.late.name, signatures)
        return template, pysig, given, NO_NAMES

    def get_overload(self, sig: Types) -> object:
        """What callers are linked with."""
        return self._stubs[tuple(sig)]

    def _address(self, args: Types) -> int:
        self.compile(args)
        found = self.overloads[args]
        if found.signature.return_type != self.late.returns:
            raise TypeError(f"{self.late.name} returns {found.signature.return_type}, not as annotated")
        return found.library.get_pointer_to_function(found.fndesc.llvm_func_name)


class StoredCode:
    """The machine code of an entry in the store, in the place of numba's own cache."""

    def __init__(self, entry: Entry, store: CodeStore) -> None:
        self.cache_path = str(store.folder)
        self.alone = ExitStack()  # what it is made under
        self._entry = entry
        self._store = store

    def load_overload(self, sig: Types, target: CPUContext) -> compiler.CompileResult | None:
        """Machine code for these types of arguments, for this processor or for any; None: it has to be compiled."""
        # what machine code allocates by; what the compiler knows it loads when it compiles
        rtsys.initialize(target)
        if (kept := self._kept(sig, target)) is not None:
            return kept
        reached = Reached(self._entry.py_func).functions
        for function in reached:
            if function in Inner.all:
                Inner.all[function].renew()
        begin_piece(self._name, len(reached))
        self.alone.enter_context(self._store.alone(self._name))
        return self._kept(sig, target)

    def _kept(self, sig: Types, target: CPUContext) -> compiler.CompileResult | None:
        triple, *processor = target.codegen().magic_tuple()
        for found in (processor, GENERIC):
            data = self._store.read(self._name, self._key(sig, triple, *found))
            if data is not None:
                called, reduced = pickle.loads(data)
                lazy_binding.make_cells(called)
                return compiler.CompileResult._rebuild(target, *reduced)
        return None

    def save_overload(self, sig: Types, cres: compiler.CompileResult) -> None:
        """Keep what was compiled; TypeError for code that holds addresses of this process."""
        if cres.library.has_dynamic_globals:
            raise TypeError(f"{self._name} holds addresses of this process")
        for environment in cres._find_referenced_environments():
            cres.codegen.set_env(environment.env_name, environment)
        data = serialize.dumps((lazy_binding.late_calls_in(cres.library), cres._reduce()))
        self._store.write(self._name, self._key(sig, *cres.codegen.magic_tuple()), data)

    def flush(self) -> None:
        """What is stored under a key stays right."""

    @property
    def _name(self) -> str:
        function = self._entry.py_func
        return f"{function.__module__}.{function.__qualname__}"

    def _key(self, sig: Types, *processor: str) -> str:
        settings = [(name, config.__dict__[name]) for name in SETTINGS]
        options = sorted(self._entry.targetoptions.items())
        given = [type_text(each) for each in sig]
        return key_of(self._entry.py_func, COMPILER, processor, settings, options, given)


def _plain(args: Types, kws: dict[str, types.Type]) -> tuple[Types, dict[str, types.Type]]:
    """A constant as argument is a number like others."""
    return tuple(types.unliteral(arg) for arg in args), {
        name: types.unliteral(arg) for name, arg in kws.items()
    }
