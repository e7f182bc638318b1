// A crack that grows through a plate, with a field: as crack.c, in Rust.
use std::ffi::c_void;
use std::mem::size_of;
use std::os::raw::{c_char, c_int};
use std::ptr::{null, null_mut};

#[repr(C)]
struct Error {
    code: i32,
    feature_count: i32,
    edit: i64,
    features: [u64; 8],
    reason: [c_char; 32],
    message: [c_char; 1024],
}

#[repr(C)]
#[derive(Clone, Copy)]
struct Column {
    data: *const c_void,
    rows: usize,
    stride: isize,
    width: i32,
    kind: i32,
}

#[repr(C)]
#[derive(Default)]
struct Options {
    size: usize,
    dimension: i32,
    kind: i32,
    criterion: i32,
    reserved: i32,
    low: [f64; 3],
    high: [f64; 3],
    quality: f64,
    max_edge: f64,
    min_dihedral: f64,
    max_vertices: u64,
}

#[repr(C)]
#[derive(Default)]
struct Field {
    size: usize,
    kind: i32,
    components: i32,
    rings: i32,
    bounded: i32,
}

#[repr(C)]
struct Choice {
    size: usize,
    polygons: Column,
    without: Column,
    open: Column,
    inside: i32,
    reserved: i32,
}

enum Mesh {}
enum Batch {}
enum Part {}

#[link(name = "dynmesh")]
extern "C" {
    fn dynmesh_fill_options(dimension: i32, options: *mut Options, size: usize);
    fn dynmesh_open(options: *const Options, mesh: *mut *mut Mesh, error: *mut Error) -> c_int;
    fn dynmesh_close(mesh: *mut Mesh);
    fn dynmesh_count(mesh: *const Mesh, which: c_int) -> u64;
    fn dynmesh_hash(mesh: *const Mesh, hash: *mut u8);
    fn dynmesh_batch_new(batch: *mut *mut Batch, error: *mut Error) -> c_int;
    fn dynmesh_batch_free(batch: *mut Batch);
    fn dynmesh_batch_clear(batch: *mut Batch);
    fn dynmesh_add_points(batch: *mut Batch, action: c_int, ids: Column, places: Column,
                          error: *mut Error) -> c_int;
    fn dynmesh_add_segments(batch: *mut Batch, action: c_int, ids: Column, ends: Column,
                            error: *mut Error) -> c_int;
    fn dynmesh_add_polygon(batch: *mut Batch, action: c_int, id: u64, corners: Column,
                           ring_ends: Column, error: *mut Error) -> c_int;
    fn dynmesh_apply(mesh: *mut Mesh, batch: *const Batch, options: *const c_void,
                     error: *mut Error) -> c_int;
    fn dynmesh_array(mesh: *const Mesh, which: c_int, column: *mut Column, error: *mut Error) -> c_int;
    fn dynmesh_fill_field(field: *mut Field, size: usize);
    fn dynmesh_carry(mesh: *mut Mesh, field: *const Field, values: *mut f64, rows: usize,
                     stride: isize, error: *mut Error) -> c_int;
    fn dynmesh_fill_choice(choice: *mut Choice, size: usize);
    fn dynmesh_part_new(mesh: *const Mesh, choice: *const Choice, part: *mut *mut Part,
                        error: *mut Error) -> c_int;
    fn dynmesh_part_free(part: *mut Part);
    fn dynmesh_part_update(part: *mut Part, mesh: *const Mesh, error: *mut Error) -> c_int;
    fn dynmesh_part_array(part: *const Part, which: c_int, column: *mut Column,
                          error: *mut Error) -> c_int;
}

const ADD: c_int = 1;
const F64: i32 = 1;
const U64: i32 = 3;
const VERTEX_SLOTS: c_int = 3;
const POINTS: c_int = 1;
const VERTEX_IDS: c_int = 2;
const PART_CELLS: c_int = 3;

fn column<T>(values: &[T], width: usize, kind: i32) -> Column {
    let data = values.as_ptr() as *const c_void;
    Column { data, rows: values.len() / width, stride: 8 * width as isize, width: width as i32, kind }
}

fn main() {
    let nothing = Column { data: null(), rows: 0, stride: 8, width: 1, kind: U64 };
    let mut error: Error = unsafe { std::mem::zeroed() };
    let (mut mesh, mut batch, mut part) = (null_mut(), null_mut(), null_mut());
    let mut array = nothing;
    let mut options = Options::default();
    let mut p1 = Field::default();
    let mut choice = Choice { size: 0, polygons: nothing, without: nothing, open: nothing, inside: 0,
                              reserved: 0 };
    let check = |code: c_int| assert_eq!(code, 0);
    unsafe {
        dynmesh_fill_options(2, &mut options, size_of::<Options>());
        options.max_edge = 0.05;
        check(dynmesh_open(&options, &mut mesh, &mut error));
        check(dynmesh_batch_new(&mut batch, &mut error));
        let corners = [1u64, 2, 3, 4];
        let places = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0];
        check(dynmesh_add_points(batch, ADD, column(&corners, 1, U64), column(&places, 2, F64), &mut error));
        check(dynmesh_add_polygon(batch, ADD, 9, column(&corners, 1, U64), column(&[4u64], 1, U64),
                                  &mut error));
        check(dynmesh_add_points(batch, ADD, column(&[5u64], 1, U64), column(&[0.125, 0.5], 2, F64),
                                 &mut error));
        check(dynmesh_apply(mesh, batch, null(), &mut error));
        dynmesh_fill_choice(&mut choice, size_of::<Choice>());
        check(dynmesh_part_new(mesh, &choice, &mut part, &mut error));

        let rows = dynmesh_count(mesh, VERTEX_SLOTS) as usize;
        check(dynmesh_array(mesh, POINTS, &mut array, &mut error));
        let points = std::slice::from_raw_parts(array.data as *const f64, 2 * rows);
        let mut u: Vec<f64> = (0..rows).map(|i| points[2 * i] * points[2 * i] + 3.0 * points[2 * i + 1]).collect();

        dynmesh_fill_field(&mut p1, size_of::<Field>());
        for k in 0..100i32 {
            let point = 101 + k as u64;
            let ends = [if k == 0 { 5 } else { point - 1 }, point];
            let place = [0.125 + f64::from(k + 1) / 160.0, 0.5 + f64::from((k * 7) % 13 - 6) / 4096.0];
            dynmesh_batch_clear(batch);
            check(dynmesh_add_points(batch, ADD, column(&[point], 1, U64), column(&place, 2, F64), &mut error));
            check(dynmesh_add_segments(batch, ADD, column(&[301 + k as u64], 1, U64), column(&ends, 2, U64),
                                       &mut error));
            check(dynmesh_apply(mesh, batch, null(), &mut error));
            let now = dynmesh_count(mesh, VERTEX_SLOTS) as usize;
            if now > u.len() {
                u.resize(now, 0.0);
            }
            check(dynmesh_carry(mesh, &p1, u.as_mut_ptr(), u.len(), 8, &mut error));
            check(dynmesh_part_update(part, mesh, &mut error));
        }

        check(dynmesh_array(mesh, VERTEX_IDS, &mut array, &mut error));
        let ids = std::slice::from_raw_parts(array.data as *const u64, u.len());
        let mut sum = 0.0;
        for (id, value) in ids.iter().zip(&u) {
            if *id != 0 {
                sum += value;
            }
        }
        let mut hash = [0u8; 33];
        dynmesh_hash(mesh, hash.as_mut_ptr());
        check(dynmesh_part_array(part, PART_CELLS, &mut array, &mut error));
        println!("{} {:016x} {}", String::from_utf8_lossy(&hash[..32]), sum.to_bits(), array.rows);
        dynmesh_part_free(part);
        dynmesh_batch_free(batch);
        dynmesh_close(mesh);
    }
}
