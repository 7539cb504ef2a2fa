"""The command palette: everything that keys do, by name."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from textual.command import DiscoveryHit, Hit, Hits, Provider

ENTRIES: tuple[tuple[str, str, str], ...] = (
    ("Hold", "ask('HOLD')", "stop and stay (h)"),
    ("Resume", "ask('RESUME')", "go on with the mission (r)"),
    ("Return home", "ask('RETURN')", "fly home, land, disarm (b)"),
    ("Land", "ask('LAND')", "land where they are (L)"),
    ("Send to the cursor", "ask_there('GO_TO')", "and hold there (o)"),
    ("Visit the cursor", "ask_there('VISIT')", "then go on with the mission (p)"),
    ("Draw a polygon", "draw", "no-fly zone, area or sector (d)"),
    ("Areas and zones", "polygons", "import, lift, share out (a)"),
    ("Speed limit", "speed", "in m/s (k)"),
    ("Re-plan", "proposal", "what the policy proposes (n)"),
    ("Troubles", "troubles", "what is wrong and what to do (t)"),
    ("Map layers", "layers", "what the map shows (l)"),
    ("Ground colours", "screen.ground", "elevation, observed, by whom, when (g)"),
    ("Curves by vehicle", "screen.contributions", "who has seen how much (v)"),
    ("Follow", "screen.follow", "keep the chosen vehicle in view (f)"),
    ("Cursor", "screen.cursor", "what is there (c)"),
    ("Theme", "theme", "night, day, mono (T)"),
    ("Help", "help", "keys and glyphs (?)"),
    ("Leave", "leave", "the mission goes on (q)"),
)


class FleetCommands(Provider):
    """Finds entries by what is typed."""

    async def discover(self) -> Hits:
        for name, action, text in ENTRIES:
            yield DiscoveryHit(name, self._run(action), help=text)

    async def search(self, query: str) -> Hits:
        matcher = self.matcher(query)
        for name, action, text in ENTRIES:
            score = matcher.match(name)
            if score > 0:
                yield Hit(score, matcher.highlight(name), self._run(action), help=text)

    def _run(self, action: str) -> Callable[[], Awaitable[None]]:
        async def run() -> None:
            await self.app.run_action(action)

        return run
