"""Named columns with units, and their forms in other libraries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.units import counted, nearest

from phaseplane import figures

from ..errors import InputError, shown
from ..look import look_of
from .picture import Picture

if TYPE_CHECKING:
    import numpy.typing as npt
    import pandas
    import pyarrow
    import xarray


class Table(Mapping[str, "npt.NDArray[Any]"]):
    """Columns of equal length by name, with their units.

    `table["body_acceleration"]` is a numpy array, which must not be changed in place.

    Parameters
    ----------
    columns : arrays of shape (rows,)
    units : of the columns, where known; "" and "1" for numbers without a unit
    index : name of the column that numbers the rows, such as `time`; "" for none
    title : title of its pictures
    """

    def __init__(
        self,
        columns: Mapping[str, npt.NDArray[Any]],
        units: Mapping[str, str] | None = None,
        index: str = "time",
        title: str = "",
    ) -> None:
        self.columns = dict(columns)
        self.units = {name: (units or {}).get(name, "") for name in self.columns}
        self.index = index if index in self.columns else ""
        self.title = title

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        if name not in self.columns:
            raise KeyError(f"no column {shown(name)}{nearest(name, self.columns)}")
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    @property
    def rows(self) -> int:
        """The number of rows."""
        return len(next(iter(self.columns.values()), ()))

    def __repr__(self) -> str:
        named = ", ".join(f"{n} [{u}]" if u not in ("", "1") else n for n, u in self.units.items())
        return f"<{type(self).__name__}: {counted(self.rows, 'row')} of {named}>"

    # -- other libraries -----------------------------------------------------------------------------

    def to_pandas(self) -> pandas.DataFrame:
        """Return a pandas DataFrame that shares the columns' memory; units are in its `attrs`.

        Raises
        ------
        ImportError : if pandas is not installed (`pip install 'phaseplane[pandas]'`).
        """
        pd = _optional("pandas")

        values = {name: column for name, column in self.items() if name != self.index}
        index = pd.Index(self[self.index], name=self.index, copy=False) if self.index else None
        frame = pd.DataFrame(values, index=index, copy=False)
        frame.attrs["units"] = dict(self.units)
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """Return an xarray Dataset that shares the columns' memory, each with the attribute `units`.

        Raises
        ------
        ImportError : if xarray is not installed (`pip install 'phaseplane[xarray]'`).
        """
        xr = _optional("xarray")

        along = self.index or "row"
        columns = {
            name: (along, column, {"units": self.units[name]} if self.units[name] else {})
            for name, column in self.items()
        }
        coordinates = {self.index: columns.pop(self.index)} if self.index else {}
        return xr.Dataset(columns, coordinates, attrs={"title": self.title} if self.title else {})

    def to_arrow(self) -> pyarrow.Table:
        """Return an Arrow table that shares the memory of numbers; units are in the fields' metadata.

        Truth values and texts are copied, as Arrow packs them.
        """
        import pyarrow as pa  # noqa: PLC0415  (heavy)

        arrays = {name: pa.array(column) for name, column in self.items()}
        fields = [
            pa.field(name, array.type, metadata={"unit": self.units[name]})
            for name, array in arrays.items()
        ]
        return pa.table(list(arrays.values()), schema=pa.schema(fields))

    # -- pictures ------------------------------------------------------------------------------------

    def plot(self, *names: str, **look: Any) -> Picture:
        """Draw columns over time, one below the other; all of them if none is named.

        Parameters
        ----------
        look : dark, width (m, or a string such as "85mm"), font, mono, headed; see `figures.Look`

        Raises
        ------
        KeyError : if there is no such column.
        InputError : if there is no time.
        """
        self._need_time()
        names = names or tuple(name for name in self if name != self.index)
        drawn = {name: {"": (self[self.index], self[name])} for name in names}
        return Picture(figures.runs(drawn, self.units, title=self.title, look=look_of(**look)))

    def plane(self, x: str, y: str, **look: Any) -> Picture:
        """Draw a column over another, such as a rate over its displacement: a phase plane.

        Parameters
        ----------
        look : as for `plot`

        Raises
        ------
        KeyError : if there is no such column.
        """
        return Picture(
            figures.plane_of_columns(
                {self.title: (self[x], self[y])},
                (x, y),
                self.units,
                title=self.title,
                look=look_of(**look),
            )
        )

    def _need_time(self) -> None:
        if self.index != "time":
            raise InputError("there is no column time; draw columns over one another with plane()")

    def at(self, time: float) -> dict[str, float]:
        """Return the values at a time, s, linearly between rows.

        Raises
        ------
        InputError : if there is no time, or it is outside the rows.
        """
        self._need_time()
        instants = self[self.index]
        if not instants[0] <= time <= instants[-1]:
            raise InputError(f"{time:g} s is outside {instants[0]:g} to {instants[-1]:g} s")
        return {name: float(np.interp(time, instants, x.astype(float))) for name, x in self.items()}


def _optional(name: str) -> Any:
    """Return a library that is installed by an extra of its name.

    Raises
    ------
    ImportError : if it is not installed.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise ImportError(f"{name} is not installed; pip install 'phaseplane[{name}]'") from error
