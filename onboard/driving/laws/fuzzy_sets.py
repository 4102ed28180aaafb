"""Fuzzy sets of the predictive fuzzy ATO (Yasunobu, Miyamoto and Ihara, 5.1): how well a figure meets a wish, 0 to 1.

Three shapes, each told by where its grade is 1, 0.5 and 0.25, and the sets of six indices made of them: safety (S),
comfort (C), energy (E), speed (T, traceability), running time (R) and accuracy of the stop (G).
"""

from __future__ import annotations

from vehicle.compiled import compiled


@compiled
def rising(x: float, a: float, b: float) -> float:
    """A(x, a, b): 1 from `a` on. Below it, b > 0 falls as a hyperbola, 0.5 at a - b and 0.25 at a - 3b.

    With b < 0 it falls in a straight line, 0.5 at a + b, 0.25 at a + 1.5b, 0 from a + 2b down; b = 0 is a step.
    """
    if x >= a:
        return 1.0
    if b > 0.0:
        return b / (a + b - x)
    if b == 0.0 or x < a + 2.0 * b:
        return 0.0
    return 1.0 + (a - x) / (2.0 * b)


@compiled
def falling(x: float, a: float, b: float) -> float:
    """B(x, a, b): 1 up to `a`, the mirror image of A."""
    return rising(2.0 * a - x, a, b)


@compiled
def peaked(x: float, a1: float, b1: float, a2: float, b2: float) -> float:
    """C(x, a1, b1, a2, b2): A and B laid over each other, 1 between a1 and a2."""
    return min(rising(x, a1, b1), falling(x, a2, b2))


# S: t_s, time until the present speed is no longer permitted, s ---------------------------------------------------


@compiled
def dangerous(limit_in_s: float, safe_s: float) -> float:
    """SD, 危険."""
    return falling(limit_in_s, -safe_s, -safe_s)


@compiled
def safe(limit_in_s: float, safe_s: float) -> float:
    """SS, 安全である."""
    return rising(limit_in_s, 0.0, -safe_s)


# C: t_c, time since the last change of notch, s, and N_c, by how many steps it changed ----------------------------


@compiled
def comfortable(held_s: float, changed: float, half_comfort_s: float) -> float:
    """CG, 乗り心地が良い: whole again a second a step after the last change, half at `half_comfort_s` a step.

    The paper's half is at C_c whatever the change, so that right after it a greater change would be the better one.
    """
    return rising(held_s, changed, -changed * (1.0 - half_comfort_s))


# E: x, where the train is, and X_k, up to where it may coast, m ---------------------------------------------------


@compiled
def saves(position_m: float, coast_to_m: float, energy_m: float) -> float:
    """ES, 省エネ走行ができる."""
    return falling(position_m, coast_to_m, -energy_m)


# T: V_p, speed predicted, and V_t, its target, m/s ----------------------------------------------------------------


@compiled
def runs_well(predicted_mps: float, target_mps: float, allowed_mps: float) -> float:
    """TG, うまく走行する: within what is allowed about the target."""
    return peaked(
        predicted_mps, target_mps - allowed_mps, allowed_mps, target_mps + allowed_mps, allowed_mps
    )


@compiled
def runs_exactly(predicted_mps: float, target_mps: float, allowed_mps: float) -> float:
    """TA, 正確に走行する: printed as C(V_p, V_s, V_s, V_t, V_s), which would be 1 at any speed below the target."""
    return peaked(predicted_mps, target_mps, allowed_mps, target_mps, allowed_mps)


@compiled
def runs_slowly(predicted_mps: float, target_mps: float) -> float:
    """TL, 走行速度が低い."""
    return falling(predicted_mps, target_mps / 2.0, target_mps / 4.0)


# R: t_b, time until the train is where its brake for the stop begins (B地点), s ---------------------------------------


@compiled
def in_stop_zone(brake_in_s: float, early_s: float) -> float:
    """RT, 定位置停止制御ゾーン内にいる."""
    return falling(brake_in_s, 0.0, -early_s)


@compiled
def in_free_zone(brake_in_s: float, early_s: float) -> float:
    """RF, 自由ゾーン内にいる."""
    return rising(brake_in_s, 2.0 * early_s, -early_s)


# G: by how much the predicted stop misses the mark, m -------------------------------------------------------------


@compiled
def stops_well(miss_m: float, allowed_m: float) -> float:
    """GG, うまく停止する: printed with X_t for the mark and for what is allowed."""
    return peaked(miss_m, -allowed_m, allowed_m, allowed_m, allowed_m)


@compiled
def stops_exactly(miss_m: float, allowed_m: float) -> float:
    """GA, 正確に停止する."""
    return peaked(miss_m, 0.0, allowed_m, 0.0, allowed_m)
