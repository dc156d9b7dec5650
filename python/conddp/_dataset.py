"""Data sets of batches as arrays."""

import os
from typing import Any, Dict, List, Sequence, Tuple, Union

import numpy

from ._extras import needed

_TABLE = ("item", "id", "status", "solver", "problem", "cost")


def _texts(values: Any) -> List[str]:
    return [v.decode() if isinstance(v, bytes) else str(v) for v in numpy.atleast_1d(values)]


class Dataset:
    """The kept motions of a batch: data["x"] is an array with one motion for each first index.

    read_dataset() makes it. len() is the number of motions, `arrays` are the names.

    Arrays are read from the file when they are asked for, so keep them in variables. Motions of
    another length, or without a contact or constraint that others have, are filled up with NaN.
    Motions with other states or controls are apart: `shapes` are data sets that fit together.
    """

    def __init__(self, file: str, groups: Sequence[str]):
        h5py = needed("h5py", "dataset", "read_dataset")
        self._file, self._groups = file, list(groups)
        self._sizes: Dict[str, Tuple[int, ...]] = {}
        self._attributes: Dict[str, List[Dict[str, List[str]]]] = {}
        tables: Dict[str, List[numpy.ndarray]] = {name: [] for name in _TABLE}
        parameters: List[numpy.ndarray] = []
        with h5py.File(file) as content:
            for name in self._groups:
                group = content[name]
                for own, rows in tables.items():
                    rows.append(group[own][:])
                self._add(group)
                if "parameters" in group:
                    parameters.append(group["parameters"][:])
        self._counts = [len(rows) for rows in tables["item"]]
        joined = {name: numpy.concatenate(rows) for name, rows in tables.items()}
        #: places of the motions in the order of the plan
        self._order = numpy.argsort(joined["item"], kind="stable")
        self._table: Dict[str, numpy.ndarray] = {}
        for name, values in joined.items():
            if values.dtype.kind in "SO":
                values = numpy.array(_texts(values), dtype=str)
            self._table[name] = (values.astype(int) if name == "item" else values)[self._order]
        self._parameters: Dict[str, numpy.ndarray] = {}
        if parameters:
            names = self._attributes["parameters"][0]["names"]
            columns = numpy.concatenate(parameters)[self._order].T
            self._parameters = dict(zip(names, columns))

    def _add(self, group: Any) -> None:
        """Takes note of the arrays of a group."""
        for name, array in group.items():
            if name in _TABLE:
                continue
            size = tuple(array.shape[1:])
            known = self._sizes.setdefault(name, size)
            if len(known) != len(size):
                raise ValueError(f"the arrays '{name}' of the data set have different dimensions")
            self._sizes[name] = tuple(max(pair) for pair in zip(known, size))
            own = {key: _texts(value) for key, value in array.attrs.items()}
            self._attributes.setdefault(name, []).append(own)

    def __getitem__(self, name: str) -> numpy.ndarray:
        """An array: 'x' (motions x nodes x nx), 'u', 'K', 't', 'cost', 'status', ..."""
        if name in self._table:
            return self._table[name]
        if name not in self._sizes:
            raise KeyError(f"{name!r}; the data set has {', '.join(self.arrays)}")
        kinds = [{k: v for k, v in own.items() if k != "units"} for own in self._attributes[name]]
        if any(kind != kinds[0] for kind in kinds):
            raise ValueError(f"'{name}' has other columns in other motions: take it from .shapes")
        out: numpy.ndarray = numpy.full((len(self), *self._sizes[name]), numpy.nan)
        h5py = needed("h5py", "dataset", "read_dataset")
        with h5py.File(self._file) as content:
            first = 0
            for group, count in zip(self._groups, self._counts):
                if name in content[group]:
                    values = content[group][name][:]
                    out[(slice(first, first + count), *map(slice, values.shape[1:]))] = values
                first += count
        if len(self._groups) > 1:
            out = out[self._order]
        return out

    def __contains__(self, name: object) -> bool:
        return name in self._table or name in self._sizes

    def __len__(self) -> int:
        """The number of motions."""
        return len(self._order)

    @property
    def arrays(self) -> List[str]:
        """The names of the arrays."""
        return [*self._table, *self._sizes]

    @property
    def parameters(self) -> Dict[str, numpy.ndarray]:
        """The varied values: a column for each name, NaN for values that are not numbers."""
        return self._parameters

    @property
    def keys_of_parameters(self) -> Dict[str, str]:
        """The keys of the problem that the parameters set, by name."""
        attributes = self._attributes.get("parameters", [{"names": [], "keys": []}])[0]
        return dict(zip(attributes["names"], attributes["keys"]))

    @property
    def columns(self) -> Dict[str, List[str]]:
        """Names of the last index of arrays, as in columns['x']; for K those of its rows."""
        return {
            name: own[0]["columns"] for name, own in self._attributes.items() if "columns" in own[0]
        }

    @property
    def units(self) -> Dict[str, List[str]]:
        """Units of the columns, as in units['x']."""
        return {
            name: own[0]["units"] for name, own in self._attributes.items() if own[0].get("units")
        }

    @property
    def lengths(self) -> numpy.ndarray:
        """The number of nodes of each motion; shorter ones are filled up with NaN."""
        return numpy.asarray(numpy.sum(~numpy.isnan(self["t"]), axis=1))

    @property
    def shapes(self) -> "List[Dataset]":
        """The motions with the same columns, numbers of knots, contacts and constraints."""
        return [Dataset(self._file, [group]) for group in self._groups]

    def to_frame(self) -> Any:
        """A pandas.DataFrame with a row for each motion: item, id, status, cost, parameters."""
        pandas = needed("pandas", "frames", "to_frame()")
        return pandas.DataFrame({**self._table, **self._parameters}).set_index("item")

    def __repr__(self) -> str:
        size = f"{len(self)} motions in {len(self._groups)} shapes"
        return f"<conddp.Dataset of {size}: {', '.join(self.arrays)}>"


def read_dataset(file: Union[str, "os.PathLike[str]"]) -> Dataset:
    """Reads dataset.h5 of a batch: data["x"], data["u"], data.parameters["goal"], ...

    Its arrays are those of the page docs/batch.md, with one motion for each first index, in the
    order of the plan. Needs the package h5py.
    """
    h5py = needed("h5py", "dataset", "read_dataset")
    path = os.fspath(file)
    with h5py.File(path) as content:
        groups = sorted(
            (name for name in content if name.startswith("shape_")), key=lambda name: int(name[6:])
        )
    if not groups:
        raise ValueError(f"'{path}' is no data set of a batch")
    return Dataset(path, groups)
