"""What the operator does to the fleet by keys: orders, zones, areas, places; each asked for before it is sent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from textual.app import App

from ground_station.area_file import AreaFileError, read_polygon
from ground_station.conditions import Trouble
from ground_station.inputs import Acknowledged, Muted
from ground_station.payload import NOTHING, EastNorth, Payload, point, polygon
from ground_station.player import Player
from ground_station.screens.choice import ChoiceDialog, Option
from ground_station.screens.command import CommandDialog
from ground_station.screens.dashboard import Dashboard
from ground_station.screens.entry import EntryDialog
from ground_station.screens.layers import LayersDialog
from ground_station.screens.proposal import ProposalDialog
from ground_station.screens.troubles import TroublesDialog
from ground_station.station import Station
from ground_station.views.ink import Look
from vehicle_agent.domain.polygon import first_crossing
from vehicle_agent.wire.messages import Verb


class Operations(App[None]):
    """The half of the app that acts; the other half listens and draws.

    Attributes
    ----------
    station
        The fleet's picture and the way to it.
    """

    station: Station | Player
    _look: Look
    _dashboard: Dashboard

    def now_s(self) -> float:
        """Station time."""
        raise NotImplementedError

    def draw(self) -> None:
        """Hand the newest picture to the screens that show it."""
        raise NotImplementedError

    def action_ask(self, verb: str) -> None:
        """Ask for an order without a payload."""
        if self._may_ask():
            self.ask(Verb[verb])

    def ask(self, verb: Verb, payload: Payload = NOTHING, chosen: str | None = None) -> None:
        """Ask whom an order is for, then send it."""
        target = self._dashboard.selected if chosen is None else chosen
        self.push_screen(CommandDialog(self._look, self.station.state, verb, self._send, payload, target))

    def action_ask_there(self, verb: str) -> None:
        """Ask whom to send to the cursor: the chosen vehicle, or the one that is nearest."""
        cursor = self._dashboard.window.cursor_en_m
        if not self._may_ask():
            return
        if cursor is None:
            self._dashboard.action_cursor()
            return
        self.ask(Verb[verb], point(cursor), self._dashboard.selected or self._nearest_to(cursor))

    def action_draw(self) -> None:
        """Put a corner at the cursor, and show the cursor first where it is hidden."""
        board = self._dashboard
        cursor = board.window.cursor_en_m
        if self._may_ask() and cursor is None:
            board.action_cursor()
        elif self._may_ask() and cursor is not None and cursor not in board.window.drawn_en_m:
            board.look_differently(replace(board.window, drawn_en_m=(*board.window.drawn_en_m, cursor)))

    def action_finish_drawing(self) -> None:
        """Ask what the drawn polygon is for."""
        corners = self._dashboard.window.drawn_en_m
        if self._may_ask() and corners:
            self.ask_for_polygon(corners)

    def ask_for_polygon(self, corners: Sequence[EastNorth]) -> None:
        """Ask what a polygon is for; crossed or too small ones are not taken."""
        if len(corners) < 3 or first_crossing(np.array(corners)) is not None:
            self._choose("A polygon needs three corners at least and must not cross itself", ())
            return

        def use(verb: Verb, number: int = 0) -> None:
            self._dashboard.look_differently(replace(self._dashboard.window, drawn_en_m=()))
            self.ask(verb, polygon(corners, number), self._dashboard.selected if verb is Verb.SECTOR else "")

        number = max(self.station.state.zones, default=0) + 1
        self._choose(
            f"A polygon of {len(corners)} corners is drawn. What is it?",
            (
                ("n", "a no-fly zone", lambda: use(Verb.NO_FLY, number)),
                ("a", "the area: only this is to be seen", lambda: use(Verb.AREA)),
                ("s", "a sector, to be seen first", lambda: use(Verb.SECTOR)),
            ),
        )

    def action_polygons(self) -> None:
        """Lift zones, take the whole area again, import, share out."""
        if not self._may_ask():
            return
        options: list[Option] = [
            ("i", "import a polygon from a GeoJSON or WKT file", self._ask_file),
            ("w", "the whole area is to be seen again", lambda: self.ask(Verb.AREA, chosen="")),
            ("s", "no sector is to be seen first any more", lambda: self.ask(Verb.SECTOR, chosen="")),
            ("x", "share the rest of the area out as sectors", self._share_out),
        ]
        for key, number in zip("123456789", sorted(self.station.state.zones), strict=False):
            options.append((key, f"lift no-fly zone {number}", lambda n=number: self._lift(n)))  # type: ignore[misc]
        self._choose("Areas and zones", options)

    def action_speed(self) -> None:
        if self._may_ask():
            question = "Speed limit in m/s (0: as the mission says)"
            self.push_screen(EntryDialog(self._look, self.station.state, question, self._take_speed))

    def action_proposal(self) -> None:
        proposal = self.station.proposal
        if proposal is None:
            self._choose("Nothing is proposed now", (("x", "share the rest out as sectors", self._share_out),))
        elif self._may_ask():
            self.push_screen(
                ProposalDialog(self._look, self.station.state, proposal, self._accept, self.station.dismiss)
            )

    def action_troubles(self) -> None:
        if self._may_ask():
            self.push_screen(TroublesDialog(self._look, self.station.state, self._acknowledge, self._mute))

    def action_layers(self) -> None:
        if self._may_ask():
            board = self._dashboard
            self.push_screen(LayersDialog(self._look, self.station.state, board.window, board.look_differently))

    def _may_ask(self) -> bool:
        return self.screen is self._dashboard and not self._dashboard.too_small

    def _choose(self, question: str, options: Sequence[Option]) -> None:
        self.push_screen(ChoiceDialog(self._look, self.station.state, question, options))

    def _nearest_to(self, place: EastNorth) -> str:
        placed = [(v.name, v.position_enu_m) for v in self.station.state.vehicles if v.position_enu_m]
        away = {name: np.hypot(where[0] - place[0], where[1] - place[1]) for name, where in placed}
        return min(away, key=lambda name: away[name], default="")

    def _ask_file(self) -> None:
        question = "GeoJSON or WKT file with a polygon in degrees"
        self.push_screen(EntryDialog(self._look, self.station.state, question, self._take_file))

    def _take_file(self, text: str) -> str:
        try:
            corners = read_polygon(Path(text).expanduser(), self.station.state.plan.datum)
        except (AreaFileError, RuntimeError) as error:  # expanduser raises RuntimeError for an unknown home
            return str(error)
        self.pop_screen()
        self.ask_for_polygon(corners)
        return ""

    def _take_speed(self, text: str) -> str:
        try:
            speed_cm_s = round(100 * float(text))
        except (ValueError, OverflowError):
            return "write a number, e.g. 7.5"
        if not 0 <= speed_cm_s <= 10_000:
            return "the speed must lie between 0 and 100 m/s"
        self.pop_screen()
        self.ask(Verb.SPEED, Payload(number=speed_cm_s))
        return ""

    def _lift(self, number: int) -> None:
        self.ask(Verb.NO_FLY, Payload(number=number), "")

    def _share_out(self) -> None:
        self.station.share_out()
        if self.station.proposal is not None:
            self.action_proposal()
        else:
            self._choose("There is nothing to share out: too few vehicles work, or too little is left", ())

    def _accept(self) -> None:
        self.station.accept(self.now_s())
        self.draw()

    def _acknowledge(self, trouble: Trouble) -> None:
        self.station.take([Acknowledged(trouble.vehicle, trouble.kind.name)])
        self.draw()

    def _mute(self, trouble: Trouble, muted: bool) -> None:
        self.station.take([Muted(trouble.vehicle, trouble.kind.name, muted)])
        self.draw()

    def _send(self, verb: Verb, targets: Sequence[str], payload: Payload) -> int | None:
        number = self.station.command(verb, targets, self.now_s(), payload)
        self.draw()
        return number
