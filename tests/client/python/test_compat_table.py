"""The right side of docs/compat_table.md: all that is asked holds, or is refused by name."""
import pytest

import compat_table as table

REFUSED = {("box", "pq33"), ("box", "pqY"), ("tower", "p"), ("tower", "pq1.2"), ("tower", "pqY")}


@pytest.mark.parametrize("name, switches", table.PLANAR + table.SOLID)
def test_what_is_asked_holds_or_is_refused(name, switches):
    found = table.ours(name, switches)
    assert isinstance(found, Exception) == ((name, switches) in REFUSED), found
    if not isinstance(found, Exception):
        assert table.faults(found, name, switches)[0] == []


def test_there_are_sixty():
    assert len(set(table.PLANAR + table.SOLID)) == 60
