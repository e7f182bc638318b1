# Debian packages, one per component; made by deploy/package.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME dynmesh)
set(CPACK_PACKAGE_VENDOR dynmesh)
set(CPACK_PACKAGE_CONTACT "dynmesh maintainers <maintainers@dynmesh.example>")
set(CPACK_COMPONENTS_ALL service development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
# With DESTDIR the prefix is the one on the target machine, which the unit names.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_SERVICE_PACKAGE_NAME dynmesh)
set(CPACK_DEBIAN_SERVICE_PACKAGE_SECTION science)
set(CPACK_DEBIAN_SERVICE_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_SERVICE_PACKAGE_DEPENDS passwd)      # useradd
set(CPACK_DEBIAN_SERVICE_PACKAGE_RECOMMENDS sqlite3)  # backups of a journal that is in use
set(CPACK_COMPONENT_SERVICE_DESCRIPTION "dynamic meshing: service and command line
Quality Delaunay meshes in the plane and in space that follow edits of their input. dynmeshd serves
them over gRPC, dynmesh makes, checks and draws them, here or on a server.")
set(debian ${PROJECT_SOURCE_DIR}/deploy/debian)
set(CPACK_DEBIAN_SERVICE_PACKAGE_CONTROL_EXTRA
  ${debian}/conffiles ${debian}/postinst ${debian}/prerm ${debian}/postrm)

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libdynmesh-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
# The Abseil with which it was compiled; others are not binary compatible.
math(EXPR next_absl "${absl_VERSION} + 1")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libabsl-dev (>= ${absl_VERSION}), libabsl-dev (<< ${next_absl})")
# For the libraries of files and of the client only; the mesher does not need them.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS "libgrpc++-dev, libprotobuf-dev, libssl-dev, zlib1g-dev, libgmp-dev")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "dynamic meshing: C++ libraries and headers
The mesher as a static library, and the client of dynmeshd, with files for CMake and pkg-config.")

if(TARGET dynmesh_c)
  list(APPEND CPACK_COMPONENTS_ALL library)
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libdynmesh0)
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)
  set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "dynamic meshing: shared library for C
Meshes that follow edits of their input, and fields on them, for programs in C, Fortran and others.")
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    ", libdynmesh0 (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
endif()

if(TARGET dynmesh_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-dynmesh)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  # The extension module requires the Python with which it was compiled.
  get_target_property(python dynmesh_python DYNMESH_PYTHON_VERSION)
  string(REPLACE "." ";" next_python ${python})
  list(GET next_python 1 next_python)
  math(EXPR next_python "${next_python} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= ${python}), python3 (<< 3.${next_python}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS python3-meshio)  # Mesh.to_meshio, Series
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "dynamic meshing: Python package
Meshes as numpy arrays that follow edits, in the process or of a dynmeshd, and fields that survive an
edit.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${debian}/python/postinst ${debian}/python/prerm)
endif()

include(CPack)
