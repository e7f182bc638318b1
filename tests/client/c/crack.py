"""A crack that grows through a plate, with a field: as crack.c, by ctypes and numpy.

    crack.py LIBRARY        # a path of libdynmesh.so.0
"""
import ctypes
import sys
from ctypes import POINTER, byref, c_double, c_int, c_int32, c_int64, c_size_t, c_uint64, c_void_p

import numpy as np

ADD, F64, I32, U64 = 1, 1, 2, 3
VERTEX_SLOTS, POINTS, VERTEX_IDS, PART_CELLS = 3, 1, 2, 3
TYPES = {F64: np.float64, I32: np.int32, U64: np.uint64}


class Error(ctypes.Structure):
    _fields_ = [("code", c_int32), ("feature_count", c_int32), ("edit", c_int64),
                ("features", c_uint64 * 8), ("reason", ctypes.c_char * 32),
                ("message", ctypes.c_char * 1024)]


class Column(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("rows", c_size_t), ("stride", ctypes.c_ssize_t),
                ("width", c_int32), ("type", c_int32)]

    def array(self):
        """A copy; without one it would end with the next batch."""
        dtype = np.dtype(TYPES[self.type])
        held = (ctypes.c_char * (self.rows * self.stride)).from_address(self.data)
        return np.ndarray((self.rows, self.width), dtype, held,
                          strides=(self.stride, dtype.itemsize)).copy()


class Options(ctypes.Structure):
    _fields_ = [("size", c_size_t), ("dimension", c_int32), ("kind", c_int32),
                ("criterion", c_int32), ("reserved", c_int32), ("low", c_double * 3),
                ("high", c_double * 3), ("quality", c_double), ("max_edge", c_double),
                ("min_dihedral", c_double), ("max_vertices", c_uint64)]


class Field(ctypes.Structure):
    _fields_ = [("size", c_size_t), ("kind", c_int32), ("components", c_int32), ("rings", c_int32),
                ("bounded", c_int32)]


class Choice(ctypes.Structure):
    _fields_ = [("size", c_size_t), ("polygons", Column), ("without", Column), ("open", Column),
                ("inside", c_int32), ("reserved", c_int32)]


library = ctypes.CDLL(sys.argv[1])
library.dynmesh_count.restype = c_uint64
error = Error()
for name in ("open", "batch_new", "add_points", "add_segments", "add_polygon", "apply", "array",
             "carry", "part_new", "part_update", "part_array"):
    getattr(library, f"dynmesh_{name}").errcheck = lambda code, *_: code and sys.exit(
        f"{code}: {error.message.decode()}")
library.dynmesh_carry.argtypes = [c_void_p, POINTER(Field), c_void_p, c_size_t, ctypes.c_ssize_t,
                                  POINTER(Error)]
library.dynmesh_add_points.argtypes = [c_void_p, c_int, Column, Column, POINTER(Error)]
library.dynmesh_add_segments.argtypes = library.dynmesh_add_points.argtypes
library.dynmesh_add_polygon.argtypes = [c_void_p, c_int, c_uint64, Column, Column, POINTER(Error)]


def column(values, dtype, kind):
    """A column, and the array that holds its rows."""
    rows = np.asarray(values, dtype)
    width = rows.shape[1] if rows.ndim == 2 else 1
    made = Column(rows.ctypes.data, len(rows), rows.strides[0], width, kind)
    made.held = rows
    return made


def u64s(values):
    return column(values, np.uint64, U64)


def f64s(values):
    return column(values, np.float64, F64)


options, mesh, batch, part = Options(), c_void_p(), c_void_p(), c_void_p()
choice, p1, out = Choice(), Field(), Column()
library.dynmesh_fill_options(2, byref(options), c_size_t(ctypes.sizeof(options)))
options.max_edge = 0.05
library.dynmesh_open(byref(options), byref(mesh), byref(error))
library.dynmesh_batch_new(byref(batch), byref(error))
library.dynmesh_add_points(batch, ADD, u64s([1, 2, 3, 4]), f64s([(0, 0), (1, 0), (1, 1), (0, 1)]),
                           byref(error))
library.dynmesh_add_polygon(batch, ADD, 9, u64s([1, 2, 3, 4]), u64s([4]), byref(error))
library.dynmesh_add_points(batch, ADD, u64s([5]), f64s([(0.125, 0.5)]), byref(error))
library.dynmesh_apply(mesh, batch, None, byref(error))

library.dynmesh_fill_choice(byref(choice), c_size_t(ctypes.sizeof(choice)))
library.dynmesh_part_new(mesh, byref(choice), byref(part), byref(error))
library.dynmesh_array(mesh, POINTS, byref(out), byref(error))
x, y = out.array().T
u = x * x + 3 * y

library.dynmesh_fill_field(byref(p1), c_size_t(ctypes.sizeof(p1)))
for k in range(100):
    point = 101 + k
    library.dynmesh_batch_clear(batch)
    library.dynmesh_add_points(batch, ADD, u64s([point]),
                               f64s([(0.125 + (k + 1) / 160, 0.5 + ((k * 7) % 13 - 6) / 4096)]),
                               byref(error))
    library.dynmesh_add_segments(batch, ADD, u64s([301 + k]),
                                 u64s([(5 if k == 0 else point - 1, point)]), byref(error))
    library.dynmesh_apply(mesh, batch, None, byref(error))
    rows = library.dynmesh_count(mesh, VERTEX_SLOTS)
    u = np.concatenate([u, np.zeros(rows - len(u))])
    library.dynmesh_carry(mesh, byref(p1), u.ctypes.data, rows, 8, byref(error))
    library.dynmesh_part_update(part, mesh, byref(error))

library.dynmesh_array(mesh, VERTEX_IDS, byref(out), byref(error))
used = out.array()[:, 0] != 0
total = 0.0
for value in u[used]:  # in this order: np.sum has another one
    total += value
text = ctypes.create_string_buffer(33)
library.dynmesh_hash(mesh, text)
library.dynmesh_part_array(part, PART_CELLS, byref(out), byref(error))
print(text.value.decode(), f"{np.float64(total).view(np.uint64):016x}", out.rows)
library.dynmesh_part_free(part)
library.dynmesh_batch_free(batch)
library.dynmesh_close(mesh)
