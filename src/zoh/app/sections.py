"""The fixed sections of a controller in a project file: notches, and pairs over pairs."""

from zoh.app.toml import Section, within
from zoh.design.sections import SecondOrder, in_series, notch
from zoh.errors import SpecError

_NOTCH = ("w0", "depth", "width")
_PAIRS = ("zeros_w0", "zeros_zeta", "poles_w0", "poles_zeta")


def read_sections(controller: Section, dt: float) -> tuple[SecondOrder, ...]:
    """Return ``sections = [{w0, depth, width}, {zeros_w0, zeros_zeta, ...}]``, checked."""
    entries = controller.data.get("sections", [])
    name = f"{controller.path}sections"
    if not isinstance(entries, list) or not all(isinstance(e, dict) for e in entries):
        way_out = "write sections = [{w0 = 20, depth = 0.1, width = 1}]"
        raise SpecError(name, "must be a list of tables", entries, way_out)
    made = [_section(Section(path=f"{name}[{i}].", data=e), dt) for i, e in enumerate(entries)]
    return tuple(made)


def _section(entry: Section, dt: float) -> SecondOrder:
    keys = _PAIRS if any(key in entry.data for key in _PAIRS) else _NOTCH
    entry.only(keys)
    found = {key: entry.number(key) for key in keys}
    values = {key: float(value) for key, value in found.items() if value is not None}
    missing = next((k for k in keys if k not in values and k not in ("depth", "width")), None)
    if missing:
        raise entry.missing(missing, f"a section has {', '.join(keys)}")
    with within(entry.path):
        section = SecondOrder(**values) if keys is _PAIRS else notch(**values)
        in_series([section], dt)
    return section
