"""One vehicle's mind: it maps, plans, talks to its team and flies its vehicle."""
