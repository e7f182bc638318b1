! A crack that grows through a plate, with a field: as crack.c, in Fortran.
module dynmesh
  use, intrinsic :: iso_c_binding
  implicit none

  integer(c_int), parameter :: add = 1, f64 = 1, u64 = 3
  integer(c_int), parameter :: vertex_slots = 3, points = 1, vertex_ids = 2, part_cells = 3

  type, bind(c) :: error_type
    integer(c_int32_t) :: code, feature_count
    integer(c_int64_t) :: edit, features(8)
    character(kind=c_char) :: reason(32), message(1024)
  end type
  type, bind(c) :: column
    type(c_ptr) :: data = c_null_ptr
    integer(c_size_t) :: rows = 0
    integer(c_ptrdiff_t) :: stride = 8
    integer(c_int32_t) :: width = 1, kind = u64
  end type
  type, bind(c) :: options_type
    integer(c_size_t) :: size
    integer(c_int32_t) :: dimension, kind, criterion, reserved
    real(c_double) :: low(3), high(3), quality, max_edge, min_dihedral
    integer(c_int64_t) :: max_vertices
  end type
  type, bind(c) :: field_type
    integer(c_size_t) :: size
    integer(c_int32_t) :: kind, components, rings, bounded
  end type
  type, bind(c) :: choice_type
    integer(c_size_t) :: size
    type(column) :: polygons, without, open
    integer(c_int32_t) :: inside, reserved
  end type

  interface
    subroutine fill_options(dimension, options, size) bind(c, name='dynmesh_fill_options')
      import
      integer(c_int32_t), value :: dimension
      type(options_type) :: options
      integer(c_size_t), value :: size
    end subroutine
    integer(c_int) function open_mesh(options, mesh, error) bind(c, name='dynmesh_open')
      import
      type(options_type) :: options
      type(c_ptr) :: mesh
      type(error_type) :: error
    end function
    subroutine close_mesh(mesh) bind(c, name='dynmesh_close')
      import
      type(c_ptr), value :: mesh
    end subroutine
    integer(c_int64_t) function count_of(mesh, which) bind(c, name='dynmesh_count')
      import
      type(c_ptr), value :: mesh
      integer(c_int), value :: which
    end function
    subroutine hash_of(mesh, hash) bind(c, name='dynmesh_hash')
      import
      type(c_ptr), value :: mesh
      character(kind=c_char) :: hash(33)
    end subroutine
    integer(c_int) function new_batch(batch, error) bind(c, name='dynmesh_batch_new')
      import
      type(c_ptr) :: batch
      type(error_type) :: error
    end function
    subroutine free_batch(batch) bind(c, name='dynmesh_batch_free')
      import
      type(c_ptr), value :: batch
    end subroutine
    subroutine clear_batch(batch) bind(c, name='dynmesh_batch_clear')
      import
      type(c_ptr), value :: batch
    end subroutine
    integer(c_int) function add_points(batch, action, ids, places, error) bind(c, name='dynmesh_add_points')
      import
      type(c_ptr), value :: batch
      integer(c_int), value :: action
      type(column), value :: ids, places
      type(error_type) :: error
    end function
    integer(c_int) function add_segments(batch, action, ids, ends, error) bind(c, name='dynmesh_add_segments')
      import
      type(c_ptr), value :: batch
      integer(c_int), value :: action
      type(column), value :: ids, ends
      type(error_type) :: error
    end function
    integer(c_int) function add_polygon(batch, action, id, corners, ring_ends, error) &
        bind(c, name='dynmesh_add_polygon')
      import
      type(c_ptr), value :: batch
      integer(c_int), value :: action
      integer(c_int64_t), value :: id
      type(column), value :: corners, ring_ends
      type(error_type) :: error
    end function
    integer(c_int) function apply(mesh, batch, options, error) bind(c, name='dynmesh_apply')
      import
      type(c_ptr), value :: mesh, batch, options
      type(error_type) :: error
    end function
    integer(c_int) function array_of(mesh, which, array, error) bind(c, name='dynmesh_array')
      import
      type(c_ptr), value :: mesh
      integer(c_int), value :: which
      type(column) :: array
      type(error_type) :: error
    end function
    subroutine fill_field(field, size) bind(c, name='dynmesh_fill_field')
      import
      type(field_type) :: field
      integer(c_size_t), value :: size
    end subroutine
    integer(c_int) function carry(mesh, field, values, rows, stride, error) bind(c, name='dynmesh_carry')
      import
      type(c_ptr), value :: mesh
      type(field_type) :: field
      real(c_double) :: values(*)
      integer(c_size_t), value :: rows
      integer(c_ptrdiff_t), value :: stride
      type(error_type) :: error
    end function
    subroutine fill_choice(choice, size) bind(c, name='dynmesh_fill_choice')
      import
      type(choice_type) :: choice
      integer(c_size_t), value :: size
    end subroutine
    integer(c_int) function new_part(mesh, choice, part, error) bind(c, name='dynmesh_part_new')
      import
      type(c_ptr), value :: mesh
      type(choice_type) :: choice
      type(c_ptr) :: part
      type(error_type) :: error
    end function
    subroutine free_part(part) bind(c, name='dynmesh_part_free')
      import
      type(c_ptr), value :: part
    end subroutine
    integer(c_int) function update_part(part, mesh, error) bind(c, name='dynmesh_part_update')
      import
      type(c_ptr), value :: part, mesh
      type(error_type) :: error
    end function
    integer(c_int) function part_array(part, which, array, error) bind(c, name='dynmesh_part_array')
      import
      type(c_ptr), value :: part
      integer(c_int), value :: which
      type(column) :: array
      type(error_type) :: error
    end function
  end interface

contains

  type(column) function u64s(values, width)
    integer(c_int64_t), target, intent(in) :: values(:)
    integer(c_int32_t), intent(in) :: width
    u64s = column(c_loc(values), size(values) / width, 8 * width, width, u64)
  end function

  type(column) function f64s(values, width)
    real(c_double), target, intent(in) :: values(:)
    integer(c_int32_t), intent(in) :: width
    f64s = column(c_loc(values), size(values) / width, 8 * width, width, f64)
  end function
end module

program crack
  use dynmesh
  implicit none
  type(error_type) :: error
  type(options_type) :: options
  type(field_type) :: p1
  type(choice_type) :: choice
  type(column) :: array
  type(c_ptr) :: mesh, batch, part
  real(c_double), allocatable, target :: u(:), larger(:)
  real(c_double), pointer :: places(:, :)
  integer(c_int64_t), pointer :: ids(:)
  integer(c_int64_t), target :: id(1), ends(2), corners(4) = [1, 2, 3, 4], ring_end(1) = [4]
  real(c_double), target :: place(2), box(8) = [0, 0, 1, 0, 1, 1, 0, 1]
  real(c_double) :: total
  integer(c_int64_t) :: rows, now, i
  integer :: k
  character(kind=c_char) :: hash(33)
  character(len=16) :: bits

  call fill_options(2, options, c_sizeof(options))
  options%max_edge = 0.05d0
  call check(open_mesh(options, mesh, error))
  call check(new_batch(batch, error))
  call check(add_points(batch, add, u64s(corners, 1), f64s(box, 2), error))
  call check(add_polygon(batch, add, 9_c_int64_t, u64s(corners, 1), u64s(ring_end, 1), error))
  id = 5
  place = [0.125d0, 0.5d0]
  call check(add_points(batch, add, u64s(id, 1), f64s(place, 2), error))
  call check(apply(mesh, batch, c_null_ptr, error))

  call fill_choice(choice, c_sizeof(choice))
  call check(new_part(mesh, choice, part, error))

  rows = count_of(mesh, vertex_slots)
  call check(array_of(mesh, points, array, error))
  call c_f_pointer(array%data, places, [2_c_int64_t, rows])
  allocate (u(rows))
  do i = 1, rows
    u(i) = places(1, i) * places(1, i) + 3 * places(2, i)
  end do

  call fill_field(p1, c_sizeof(p1))
  do k = 0, 99
    id = 101 + k
    ends = [merge(5_c_int64_t, id(1) - 1, k == 0), id(1)]
    place = [0.125d0 + (k + 1) / 160.0d0, 0.5d0 + (mod(k * 7, 13) - 6) / 4096.0d0]
    call clear_batch(batch)
    call check(add_points(batch, add, u64s(id, 1), f64s(place, 2), error))
    id = 301 + k
    call check(add_segments(batch, add, u64s(id, 1), u64s(ends, 2), error))
    call check(apply(mesh, batch, c_null_ptr, error))
    now = count_of(mesh, vertex_slots)
    if (now > rows) then
      allocate (larger(now))
      larger(:rows) = u
      larger(rows + 1:) = 0
      call move_alloc(larger, u)
      rows = now
    end if
    call check(carry(mesh, p1, u, rows, 8_c_ptrdiff_t, error))
    call check(update_part(part, mesh, error))
  end do

  call check(array_of(mesh, vertex_ids, array, error))
  call c_f_pointer(array%data, ids, [rows])
  total = 0
  do i = 1, rows
    if (ids(i) /= 0) total = total + u(i)
  end do
  write (bits, '(z16.16)') transfer(total, 1_c_int64_t)
  call hash_of(mesh, hash)
  call check(part_array(part, part_cells, array, error))
  print '(32a1, 1x, a, 1x, i0)', hash(:32), bits, array%rows
  call free_part(part)
  call free_batch(batch)
  call close_mesh(mesh)

contains

  subroutine check(code)
    integer(c_int), intent(in) :: code
    if (code == 0) return
    print *, code, error%message
    stop 1
  end subroutine
end program
