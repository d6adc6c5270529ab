# SPDX-License-Identifier: LGPL-3.0-or-later
import numpy as np
import numpy.typing as npt

def overlap_points(
    nodes: npt.NDArray[np.float64],
    normals: npt.NDArray[np.float64],
    other: npt.NDArray[np.float64],
    starts: npt.NDArray[np.int64],
    candidates: npt.NDArray[np.int64],
    points: npt.NDArray[np.float64],
    weights: npt.NDArray[np.float64],
    max_gap: float,
) -> tuple[
    npt.NDArray[np.int64],
    npt.NDArray[np.int64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
]: ...
def overlap_points_in_space(
    nodes: npt.NDArray[np.float64],
    normals: npt.NDArray[np.float64],
    other: npt.NDArray[np.float64],
    starts: npt.NDArray[np.int64],
    candidates: npt.NDArray[np.int64],
    square: npt.NDArray[np.float64],
    square_weights: npt.NDArray[np.float64],
    triangle: npt.NDArray[np.float64],
    triangle_weights: npt.NDArray[np.float64],
    max_gap: float,
) -> tuple[
    npt.NDArray[np.int64],
    npt.NDArray[np.int64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
]: ...
def tabulate(
    kernel: int,
    constants: npt.NDArray[np.float64],
    coefficients: npt.NDArray[np.float64],
    coordinates: npt.NDArray[np.float64],
    sides: npt.NDArray[np.int32],
    size: int,
) -> npt.NDArray[np.float64]: ...
def fit_moments(
    tables: npt.NDArray[np.float64],
    first: float,
    step: float,
    shares: npt.NDArray[np.float64],
    moments: npt.NDArray[np.float64],
    sigma: npt.NDArray[np.float64],
    bends: npt.NDArray[np.float64],
    terms: int,
    farthest: float,
    corrections: int,
) -> npt.NDArray[np.float64]: ...
def combine_blocks(
    matrix: npt.NDArray[np.float64],
    row_nodes: npt.NDArray[np.int64],
    tested: npt.NDArray[np.float64],
    column_nodes: npt.NDArray[np.int64],
    trial: npt.NDArray[np.float64],
    out: npt.NDArray[np.float32] | npt.NDArray[np.float64],
) -> None: ...
def follow_edge(
    hold: npt.NDArray[np.float64],
    shear: npt.NDArray[np.float64],
    friction: npt.NDArray[np.float64],
    slid: npt.NDArray[np.float64],
    first: int,
    at_once: bool,
) -> tuple[
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
    npt.NDArray[np.int64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
]: ...
def use_routines(single: list[int], double: list[int]) -> None: ...
def use_threads(count: int) -> None: ...
def factorise(
    matrix: npt.NDArray[np.float32] | npt.NDArray[np.float64], pivots: npt.NDArray[np.int32]
) -> int: ...
def invert_triangle(matrix: npt.NDArray[np.float64]) -> int: ...
def multiply_symmetric(
    matrix: npt.NDArray[np.float64],
    vector: npt.NDArray[np.float64],
    out: npt.NDArray[np.float64],
) -> None: ...
def multiply(
    matrix: npt.NDArray[np.float64],
    vectors: npt.NDArray[np.float64],
    out: npt.NDArray[np.float64],
) -> None: ...
def multiply_triangle(
    matrix: npt.NDArray[np.float64],
    transpose: bool,
    vectors: npt.NDArray[np.float64],
    out: npt.NDArray[np.float64],
) -> None: ...
def combine_rows(
    matrix: npt.NDArray[np.float64],
    rows: npt.NDArray[np.int64],
    weights: npt.NDArray[np.float64],
    out: npt.NDArray[np.float64],
) -> None: ...
def gather(
    matrix: npt.NDArray[np.float64],
    rows: npt.NDArray[np.int64],
    columns: npt.NDArray[np.int64],
    out: npt.NDArray[np.float64],
) -> None: ...
