"""The two lines on top: how the mission stands, and the one thing that the operator should know now."""

from __future__ import annotations

from ground_station.conditions import Kind
from ground_station.picture import Condition, FleetState, Phase
from ground_station.prediction import predict
from ground_station.text import age, clean, duration
from ground_station.views import palette
from ground_station.views.ink import Ink, Line, Look, Span, line_of
from vehicle_agent.wire.messages import Severity


def header_line(state: FleetState, width: int, look: Look) -> Line:
    """Mission, phase, vehicle time, speed-up, coverage and how many vehicles are heard."""
    bar = look.ink(bg=palette.BAR)
    strong = look.ink(bg=palette.BAR, bold=True)
    speedup = state.speedup
    spans: list[Span] = [
        (f" {state.plan.mission.name} ", look.ink(palette.ACCENT, palette.BAR, bold=True)),
        (f" {state.phase.value} ", bar),
        (f" {duration(state.elapsed_s)} ", strong),
    ]
    if speedup is not None:
        spans.append((f" {look.glyph('×', 'x')}{round(speedup, 1):g} ", bar))  # noqa: RUF001
    spans.append((f" {100 * state.coverage:.1f}% seen ", strong))
    prediction = predict(state)
    if prediction is not None and state.phase is Phase.WORKING:
        spans.append((f" {duration(prediction.remaining_s)} to go ", bar))
    for condition, colour in (
        (Condition.LIVE, palette.GOOD),
        (Condition.SUSPECT, palette.WARN),
        (Condition.LOST, palette.BAD),
        (Condition.AWAITED, palette.QUIET),
        (Condition.LEFT, palette.ACCENT),
    ):
        if count := state.count(condition):
            spans.append(
                (f" {count} {condition.value}", look.ink(colour, palette.BAR, bold=condition is Condition.LOST))
            )
    if missing := state.records_missing:
        spans.append((f"  {missing} map records to come", look.ink(palette.WARN, palette.BAR)))
    used = sum(len(text) for text, _ in spans)
    return (*spans, (" " * max(0, width - used), bar))


def banner_line(state: FleetState, notice: str, look: Look) -> Line:
    """The most urgent of: lost vehicles, a notice from who started this, waiting, the end; else the title."""
    alarm = look.ink((0, 0, 0), palette.BAD, bold=True) if look.colour else Ink(bold=True, reverse=True)
    troubles = [trouble for trouble in state.audible_troubles if not trouble.acknowledged]
    gone = {trouble.vehicle for trouble in troubles if trouble.kind in (Kind.AGENT_DEAD, Kind.OUT_OF_REACH)}
    lost = [vehicle for vehicle in state.vehicles if vehicle.name in gone]
    if lost:
        names = ", ".join(f"{vehicle.name} {age(state.now_s - vehicle.condition_since_s)}" for vehicle in lost)
        dead = any(trouble.kind is Kind.AGENT_DEAD for trouble in troubles)
        hint = "each autopilot's failsafe brings it home" if dead else "out of reach; what flies on, flies by itself"
        hint = "the mission has ended" if state.phase is Phase.DONE else hint
        return line_of((f" LOST {names} ", alarm), f"  {hint}")
    grave = next((trouble for trouble in troubles if trouble.severity <= Severity.WARNING), None)
    if grave is not None:
        colour = palette.BAD if grave.severity <= Severity.ERROR else palette.WARN
        head = (f" {grave.kind.value.upper()} {grave.vehicle} ", look.ink(colour, bold=True))
        more = f"  ({len(troubles) - 1} more)" if len(troubles) > 1 else ""
        return line_of(head, f"{grave.text}{more}", ("  t: what to do", look.ink(palette.QUIET)))
    live = any(vehicle.condition in (Condition.LIVE, Condition.SUSPECT) for vehicle in state.vehicles)
    if notice and not live:
        return line_of((f" {clean(notice)}", look.ink(palette.WARN)))
    if state.phase is Phase.WAITING:
        awaited = ", ".join(vehicle.name for vehicle in state.vehicles if vehicle.status is None)
        waited_s = state.now_s - state.began_s
        return line_of((f" waiting for vehicles: {awaited} ({waited_s:.0f} s)", look.ink(palette.WARN)))
    if state.phase is Phase.DONE:
        return line_of((" the mission has ended; q leaves the dashboard", look.ink(palette.ACCENT, bold=True)))
    return line_of((f" {clean(state.plan.mission.title or state.plan.mission.name)}", look.ink(palette.QUIET)))
