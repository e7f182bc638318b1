# The files of `cmake --install`. The components are Debian's packages (package.cmake): `service`
# has the programs and the unit of dynmeshd, `development` the libraries and headers, `library` the
# shared library for C, `python` the Python package.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# ---- the libraries
# Those of C++ are static (core/CMakeLists.txt), whatever BUILD_SHARED_LIBS is: the interface passes
# containers, including Abseil's, by value, so it is stable only for the same compiler and Abseil.
# So there is no VERSION or SOVERSION; programs can check dynmesh/version.h.
set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/dynmesh)
set(pc_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
cmake_path(RELATIVE_PATH CMAKE_INSTALL_PREFIX
  BASE_DIRECTORY ${CMAKE_INSTALL_PREFIX}/${pc_folder} OUTPUT_VARIABLE pc_to_prefix)

# install_library(EXPORT TARGETS...)
function(install_library export)
  install(TARGETS ${ARGN} EXPORT ${export}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT ${export} NAMESPACE dynmesh:: DESTINATION ${config_folder} COMPONENT development)
endfunction()

# install_pc(FILE TARGETS...): installs a pkg-config file; absl::x is named absl_x there.
function(install_pc file)
  set(absl ${ARGN})
  list(REMOVE_DUPLICATES absl)
  list(TRANSFORM absl REPLACE "::" "_")
  list(JOIN absl " " absl)
  configure_file(${CMAKE_CURRENT_FUNCTION_LIST_DIR}/${file}.in
    ${CMAKE_CURRENT_BINARY_DIR}/${file} @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${file} DESTINATION ${pc_folder} COMPONENT development)
endfunction()

# install_headers(FOLDER)
function(install_headers folder)
  install(DIRECTORY ${folder}/dynmesh DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
    COMPONENT development FILES_MATCHING PATTERN "*.h")
endfunction()

install_library(dynmesh-targets dynmesh dynmesh_headers dynmesh_engine)
install_headers(core/include)
install_headers(${DYNMESH_ENGINE_INCLUDE})
install_pc(dynmesh.pc absl::status absl::statusor absl::time ${DYNMESH_ABSL})
if(TARGET dynmesh_files)
  install_library(dynmesh-files-targets dynmesh_files)
  install_pc(dynmesh-files.pc ${DYNMESH_FILES_ABSL})
endif()
if(TARGET dynmesh_surfaces)
  install_library(dynmesh-surfaces-targets dynmesh_surfaces)
  get_property(surfaces_absl GLOBAL PROPERTY DYNMESH_SURFACES_ABSL)
  install_pc(dynmesh-surfaces.pc ${surfaces_absl})
endif()
if(TARGET dynmesh_client)
  install_library(dynmesh-client-targets
    dynmesh_client dynmesh_client_headers dynmesh_codec_headers)
  install_headers(client/include)
  install_headers(proto/codec/include)
  install_pc(dynmesh-client.pc absl::cord absl::strings)
  # The protocol, for clients in other languages; the journal's format is not part of it.
  install(DIRECTORY proto/dynmesh DESTINATION ${CMAKE_INSTALL_DATADIR}/dynmesh/proto
    COMPONENT development FILES_MATCHING PATTERN "*.proto" PATTERN "journal.proto" EXCLUDE)
endif()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/dynmesh-config.cmake.in
  dynmesh-config.cmake INSTALL_DESTINATION ${config_folder} NO_SET_AND_CHECK_MACRO)
# Below 1.0 a minor version may change the API.
write_basic_package_version_file(dynmesh-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${CMAKE_CURRENT_BINARY_DIR}/dynmesh-config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/dynmesh-config-version.cmake
  DESTINATION ${config_folder} COMPONENT development)

# ---- the C interface
if(TARGET dynmesh_c)
  install(TARGETS dynmesh_c LIBRARY
    DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT development)
  install(FILES client/c/dynmesh.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
  install_pc(dynmesh-c.pc)
endif()

# ---- documents; Debian expects the licence in `copyright`
function(install_documents component folder)
  install(FILES ${ARGN} DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${folder} COMPONENT ${component})
  install(FILES LICENSE RENAME copyright
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${folder} COMPONENT ${component})
endfunction()
# install_licences(COMPONENT FOLDER PACKAGES...): those of archives that are linked in (link-archives).
function(install_licences component folder)
  foreach(package ${ARGN})
    install(FILES /usr/share/doc/${package}/copyright RENAME copyright.${package}
      DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${folder} COMPONENT ${component} OPTIONAL)
  endforeach()
endfunction()
install_documents(development libdynmesh-dev LICENSE CHANGELOG.md)
string(REGEX MATCH "^[0-9]+" compiler "${CMAKE_CXX_COMPILER_VERSION}")
if(TARGET dynmesh_c)
  install_documents(library libdynmesh0 LICENSE CHANGELOG.md)
  install_licences(library libdynmesh0 libabsl-dev zlib1g-dev libstdc++-${compiler}-dev)
endif()

# ---- the Python package
# Debian's Python searches there with the prefix /usr; with another prefix set PYTHONPATH.
if(TARGET dynmesh_python)
  set(DYNMESH_PYTHON_FOLDER lib/python3/dist-packages CACHE STRING
    "Where the Python package is installed, below the prefix")
  set(modules dynmesh_python)
  if(TARGET dynmesh_python_service)
    list(APPEND modules dynmesh_python_service)
  endif()
  install(TARGETS ${modules}
    LIBRARY DESTINATION ${DYNMESH_PYTHON_FOLDER}/dynmesh COMPONENT python)
  install(DIRECTORY client/python/dynmesh DESTINATION ${DYNMESH_PYTHON_FOLDER} COMPONENT python
    FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed" PATTERN __pycache__ EXCLUDE)
  # For pip and importlib.metadata.
  configure_file(client/python/METADATA.in METADATA @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/METADATA
    DESTINATION ${DYNMESH_PYTHON_FOLDER}/dynmesh-${PROJECT_VERSION}.dist-info COMPONENT python)
  install_documents(python python3-dynmesh LICENSE CHANGELOG.md)
endif()

# ---- the programs and the service
if(TARGET dynmesh_cli AND TARGET dynmeshd)
  install(TARGETS dynmesh_cli dynmeshd
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT service)
  get_target_property(pages dynmesh_help_pages FOLDER_OF_PAGES)
  install(FILES ${pages}/dynmesh.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT service)
  install(FILES ${pages}/dynmesh.bash RENAME dynmesh
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT service)
  install_documents(service dynmesh LICENSE CHANGELOG.md deploy/RUNBOOK.md)
  install_licences(service dynmesh
    libabsl-dev libc-ares-dev libgrpc-dev libprotobuf-dev libre2-dev libstdc++-${compiler}-dev)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/install_service.cmake.in install_service.cmake @ONLY)
  install(SCRIPT ${CMAKE_CURRENT_BINARY_DIR}/install_service.cmake COMPONENT service)
endif()
