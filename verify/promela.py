"""The explored line as a model in Promela, for a second tool: the tables of the parties' steps, and how they compose,
written out, without any trouble (loss, delay, power and words at 0).

The route. A walk through all states by `verify.composition` makes every step of every party; each becomes a line of the
model, its local states and telegrams by their numbers. What the parties have between them is written out: queues
(a number each, seven bits a telegram, the oldest lowest), who may act while telegrams are on the air, guards,
correlations and tokens counted anew. A step of the line is one `atomic`; each prints the state that it leads to, so
that the sets can be compared, not only counted.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from typing import Any, Final

from verify import tokens
from verify.composition import Composition, StateOfLine
from verify.explored_line import TERMINALS, ExploredLine, UnwishedFor
from verify.happening import GuardKind
from verify.parties import FIXED_MAX, ExploredParties, LocalEvent, Sends, StepKind
from verify.terminal import LIES, lie_code
from verify.train import PEERS

_BITS: Final = 7  # of a telegram in a queue
_ALL: Final = (1 << _BITS) - 1
_LONGEST: Final = 30 // _BITS  # a queue
_WAYS: Final = 2 * len(PEERS)
STATE: Final = "STATE "  # what a line that prints a state begins with


def walked(line: ExploredLine) -> tuple[Composition, frozenset[StateOfLine]]:
    """Every state by the plain composition, and the steps that it made."""
    if any(line.budgets):
        raise ValueError("a model in Promela has no troubles")
    composition = Composition(ExploredParties(line))
    queue = deque([composition.start()])
    seen = set(queue)
    while queue:
        for found in composition.following(queue.popleft()):
            if found.state not in seen:
                seen.add(found.state)
                queue.append(found.state)
    return composition, frozenset(seen)


def state_words(state: StateOfLine) -> str:
    """A state as the model prints it."""
    numbers = [state.manager, *state.terminals]
    for cell in state.cells:
        numbers += [cell.train, cell.granted, *map(_packed, cell.air)]
    return " ".join(map(str, numbers))


def _packed(queue: tuple[int, ...]) -> int:
    if len(queue) > _LONGEST:
        raise OverflowError(f"{len(queue)} telegrams in a queue; it holds {_LONGEST}")
    return sum(telegram + 1 << _BITS * at for at, telegram in enumerate(queue))


def model(composition: Composition) -> str:
    """The model."""
    return "\n".join(_Model(composition).lines()) + "\n"


class _Model:
    def __init__(self, composition: Composition) -> None:
        self._composition: Final = composition
        self._parties: Final = composition.parties
        self._units: Final = range(len(self._parties.units))
        if len(self._parties.telegrams.things) >= 1 << _BITS:
            raise OverflowError(
                f"{len(self._parties.telegrams.things)} telegrams; a queue has {_BITS} bits for each"
            )

    def lines(self) -> Iterator[str]:
        """Line by line."""
        units = len(self._units)
        yield "/* made by `branchline verify promela` from the tables of the parties' steps */"
        yield f"short m; short t[{len(TERMINALS)}]; short tr[{units}]; byte gr[{units}]; int q[{units * _WAYS}];"
        yield "hidden int x, n, c, r, k, w, used, bits, uses, later, shift;"
        yield from self._facts()
        yield from self._queues()
        yield from self._renamed()
        yield from self._anew()
        yield from self._settled()
        yield "init {"
        yield "do :: atomic { if"
        for unit in self._units:
            yield from self._deliveries(unit)
            yield from self._train_events(unit)
        yield from self._ground_events()
        yield "fi; settled() } od }"

    # tables -----------------------------------------------------------------------------------------------------------

    def _made(self, kind: StepKind) -> list[tuple[Any, ...]]:
        return [tuple(of) for number, *of in self._parties.made if number == kind.value]

    def _facts(self) -> Iterator[str]:
        """What is looked at of local states and telegrams, as a choice by their numbers."""
        parties = self._parties
        telegrams, managers = parties.telegrams.things, parties.managers.things
        yield from _chosen("corr_of", "c", [t.correlation for t in telegrams])
        yield from _chosen("bits_of_t", "uses", [tokens.of_telegram(t) for t in telegrams])
        yield from _chosen("bits_of_m", "uses", [tokens.of_manager(m) for m in managers])
        yield from _chosen("counter_of", "c", [m.kept.register.counter for m in managers])
        yield from _chosen("grants_of", "c", [parties.manager_grants(i) for i in range(len(managers))])
        for index, terminals in enumerate(parties.terminals):
            yield from _chosen(f"bits_of_p{index}", "uses", [tokens.of_terminal(t) for t in terminals.things])
        for unit, trains in enumerate(parties.trains):
            yield from _chosen(f"bits_of_u{unit}", "uses", [tokens.of_train(t) for t in trains.things])
            yield from _chosen(
                f"open_of_u{unit}", "uses", [_mask(n for _, n in t.numbers.open) for t in trains.things]
            )

    def _queues(self) -> Iterator[str]:
        yield (
            "inline put(i, y) { shift = 0; do :: (q[i] >> shift) > 0 -> shift = shift + "
            f"{_BITS} :: else -> break od; q[i] = q[i] + ((y + 1) << shift) }}"
        )
        yield f"inline take(i) {{ x = (q[i] & {_ALL}) - 1; q[i] = q[i] >> {_BITS} }}"
        yield (
            f"inline rank(y) {{ r = {FIXED_MAX}; k = {FIXED_MAX + 1}; do :: k <= y ->"
            " if :: used & (1 << k) -> r++ :: else fi; k++ :: else -> break od }"
        )

    def _renamed(self) -> Iterator[str]:
        """Correlations counted anew, between one unit and the ground."""
        rows = (
            f":: x == {t} && r == {number} -> later = {self._parties.make(StepKind.TELEGRAM_RENAMED, t, number)}"
            for t, number in self._made(StepKind.TELEGRAM_RENAMED)
        )
        yield "inline telegram_renamed() { if " + " ".join(rows) + " :: else -> later = x fi }"
        for unit in self._units:
            first = unit * _WAYS
            steps = (of for of in self._made(StepKind.UNIT_RENAMED) if of[0] == unit)
            rows = (
                f":: tr[{unit}] == {train} && used == {_mask(n for n, _ in renamed)} ->"
                f" tr[{unit}] = {self._parties.make(StepKind.UNIT_RENAMED, unit, train, renamed, counted)}"
                for _, train, renamed, counted in steps
            )
            gather = _each_telegram(first, first + _WAYS, "corr_of(x); used = used | (1 << c)")
            change = _each_telegram(
                first,
                first + _WAYS,
                f"corr_of(x); if :: c > {FIXED_MAX} -> rank(c); if :: r != c -> telegram_renamed();"
                " q[w] = q[w] + ((later - x) << n) :: else fi :: else fi",
            )
            yield f"inline renamed{unit}() {{ open_of_u{unit}(tr[{unit}]); used = uses | (1 << gr[{unit}]); {gather};"
            yield f"used = used & {~((1 << FIXED_MAX + 1) - 1) & (1 << 30) - 1};"
            yield f"{change}; if :: gr[{unit}] > {FIXED_MAX} -> rank(gr[{unit}]); gr[{unit}] = r :: else fi;"
            yield "if " + " ".join(rows) + " :: else fi }"

    def _anew(self) -> Iterator[str]:
        """Tokens counted anew."""
        make = self._parties.make
        telegram = (
            f":: x == {t} && bits == {bits} -> later = {make(StepKind.TELEGRAM_ANEW, t, bits)}"
            for t, bits in self._made(StepKind.TELEGRAM_ANEW)
        )
        yield "inline telegram_anew() { if " + " ".join(telegram) + " :: else -> later = x fi }"
        parts: list[tuple[str, StepKind, tuple[int, ...]]] = [("m", StepKind.MANAGER_ANEW, ())]
        parts += [(f"t[{index}]", StepKind.TERMINAL_ANEW, (index,)) for index in range(len(TERMINALS))]
        parts += [(f"tr[{unit}]", StepKind.UNIT_ANEW, (unit,)) for unit in self._units]
        yield "inline anew() {"
        for name, kind, which in parts:
            rows = (
                f":: {name} == {of[-2]} && bits == {of[-1]} -> {name} = {make(kind, *of)}"
                for of in self._made(kind)
                if of[:-2] == which
            )
            yield "if " + " ".join(rows) + " :: else fi;"
        ways = len(self._units) * _WAYS
        yield _each_telegram(0, ways, "telegram_anew(); q[w] = q[w] + ((later - x) << n)") + " }"

    def _settled(self) -> Iterator[str]:
        yield "inline settled() { grants_of(m);"
        for unit in self._units:
            yield f"if :: (c >> {unit}) & 1 -> skip :: else -> gr[{unit}] = 0 fi;"
        yield from (f"renamed{unit}();" for unit in self._units)
        yield "bits_of_m(m); bits = uses;"
        yield from (f"bits_of_p{i}(t[{i}]); bits = bits | uses;" for i in range(len(TERMINALS)))
        yield from (f"bits_of_u{unit}(tr[{unit}]); bits = bits | uses;" for unit in self._units)
        yield _each_telegram(0, len(self._units) * _WAYS, "bits_of_t(x); bits = bits | uses") + ";"
        yield "counter_of(m); if :: bits == (1 << c) - 1 -> skip :: else -> anew() fi;"
        shown = ["now.m", *(f"now.t[{i}]" for i in range(len(TERMINALS)))]
        for unit in self._units:
            shown += [
                f"now.tr[{unit}]",
                f"now.gr[{unit}]",
                *(f"now.q[{unit * _WAYS + w}]" for w in range(_WAYS)),
            ]
        form = STATE + " ".join("%d" for _ in shown)
        yield f'c_code {{ printf("{form}\\n", {", ".join(shown)}); }} }}'

    # steps ------------------------------------------------------------------------------------------------------------

    def _deliveries(self, unit: int) -> Iterator[str]:
        make = self._parties.make
        for peer in range(len(PEERS)):
            up, down = unit * _WAYS + 2 * peer, unit * _WAYS + 2 * peer + 1
            rows = (
                f":: tr[{unit}] == {train} && x == {x} -> tr[{unit}] ="
                f" {(made := make(StepKind.UNIT_HEARS, unit, train, peer, x)).state}; {self._up(unit, made.sends)}"
                for u, train, p, x in self._made(StepKind.UNIT_HEARS)
                if (u, p) == (unit, peer)
            )
            yield _step(f"q[{down}] > 0", f"take({down}); if {' '.join(rows)} fi")
            if peer == 0:
                rows = (
                    f":: m == {m} && x == {x} && gr[{unit}] == {granted} ->"
                    f" m = {(made := make(StepKind.MANAGER_HEARS, m, unit, x, granted)).state};"
                    f" gr[{unit}] = {made.granted}; {_down(0, made.sends)}"
                    for m, u, x, granted in self._made(StepKind.MANAGER_HEARS)
                    if u == unit
                )
            else:
                at = peer - 1
                rows = (
                    f":: t[{at}] == {state} && x == {x} ->"
                    f" t[{at}] = {(made := make(StepKind.TERMINAL_HEARS, at, state, unit, x)).state};"
                    f" {_down(peer, made.sends)}"
                    for i, state, u, x in self._made(StepKind.TERMINAL_HEARS)
                    if (i, u) == (at, unit)
                )
            yield _step(f"q[{up}] > 0", f"take({up}); if {' '.join(rows)} fi")

    def _up(self, unit: int, sends: Sends) -> str:
        return " ".join(f"put({unit * _WAYS + 2 * peer}, {x});" for peer, x in sends) + " skip"

    def _train_events(self, unit: int) -> Iterator[str]:
        quiet = " && ".join(f"q[{unit * _WAYS + way}] == 0" for way in range(_WAYS))
        for _, train in (of for of in self._made(StepKind.UNIT_EVENTS) if of[0] == unit):
            for event in self._parties.make(StepKind.UNIT_EVENTS, unit, train):
                if event.trouble is UnwishedFor.NONE:
                    when = f"tr[{unit}] == {train} && {quiet} && {self._guard(unit, event)}"
                    then = (
                        f"tr[{unit}] = {event.state}; {self._up(unit, event.sends)}; {self._elsewhere(event)}"
                    )
                    yield _step(when, then)

    def _guard(self, unit: int, event: LocalEvent) -> str:
        guard = event.guard
        if guard.kind is GuardKind.NONE:
            return "true"
        if guard.kind is GuardKind.FREE:
            there = [
                f"tr[{other}] != {train}"
                for other in self._units
                if other != unit
                for train, known in enumerate(self._parties.trains[other].things)
                if self._parties.train_models[other].occupied(known) & guard.of
            ]
            return "(" + " && ".join(there or ["true"]) + ")"
        assert guard.position is not None
        lies = [
            f"t[{guard.of}] == {number}"
            for number, known in enumerate(self._parties.terminals[guard.of].things)
            if lie_code(known) == LIES[guard.position]
        ]
        said = "(" + " || ".join(lies or ["false"]) + ")"
        return said if guard.kind is GuardKind.LIES else f"!{said}"

    def _elsewhere(self, event: LocalEvent) -> str:
        make, words = self._parties.make, list[str]()
        if event.left:
            rows = (
                f":: m == {m} -> m = {(made := make(StepKind.BOUNDARY_PASSED, m)).state}; {_down(0, made.sends)}"
                for (m,) in self._made(StepKind.BOUNDARY_PASSED)
            )
            words.append("if " + " ".join(rows) + " fi")
        if event.locks or event.unlocks:
            raise ValueError("nobody locks points by hand without a trouble")
        return "; ".join(words) or "skip"

    def _ground_events(self) -> Iterator[str]:
        ways = [unit * _WAYS for unit in self._units]
        parties: list[tuple[str, int, StepKind, tuple[int, ...]]] = [("m", 0, StepKind.MANAGER_EVENTS, ())]
        parties += [(f"t[{i}]", i + 1, StepKind.TERMINAL_EVENTS, (i,)) for i in range(len(TERMINALS))]
        for name, peer, kind, which in parties:
            quiet = " && ".join(f"q[{way + 2 * peer + side}] == 0" for way in ways for side in (0, 1))
            for of in (of for of in self._made(kind) if of[:-1] == which):
                for event in self._parties.make(kind, *of):
                    if event.trouble is UnwishedFor.NONE:
                        then = f"{name} = {event.state}; {_down(peer, event.sends)}"
                        yield _step(f"{name} == {of[-1]} && {quiet} && {self._true(event)}", then)

    def _true(self, event: LocalEvent) -> str:
        """Whether what a person says is so; no telegram is under way then."""
        if event.about < 0:
            return "true"
        unit, model = event.about, self._parties.train_models[event.about]
        so = [
            f"tr[{unit}] == {number}"
            for number, train in enumerate(self._parties.trains[unit].things)
            if (event.corrects or not model.speaks(train)) and event.stands == model.seen_or_shown(train)
        ]
        return "(" + " || ".join(so or ["false"]) + ")"


def _each_telegram(first: int, beyond: int, does: str) -> str:
    """Something done with each telegram, as `x`, of the queues `w`, where it lies `n` bits up."""
    return (
        f"w = {first}; do :: w < {beyond} -> n = 0; do :: (q[w] >> n) > 0 ->"
        f" x = ((q[w] >> n) & {_ALL}) - 1; {does}; n = n + {_BITS} :: else -> break od; w++ :: else -> break od"
    )


def _mask(numbers: Iterable[int]) -> int:
    mask = 0
    for number in numbers:
        mask |= 1 << number
    return mask


def _chosen(name: str, what: str, values: Iterable[int]) -> Iterator[str]:
    rows = " ".join(f":: y == {number} -> {what} = {value}" for number, value in enumerate(values))
    yield f"inline {name}(y) {{ if {rows} fi }}"


def _down(peer: int, sends: Sends) -> str:
    return " ".join(f"put({unit * _WAYS + 2 * peer + 1}, {x});" for unit, x in sends) + " skip"


def _step(when: str, then: str) -> str:
    return f":: {when} -> {then}"


__all__ = ["STATE", "model", "state_words", "walked"]
