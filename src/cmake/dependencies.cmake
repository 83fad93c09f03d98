# What nanoweft is linked with, by any of the names under which it is usually installed: for the build itself, and for
# find_package(nanoweft) in other projects. Sets NANOWEFT_DEPENDENCIES.
#
# pkg-config's files are asked first (Debian, Spack, conda, modules), then PETSC_DIR, HDF5_ROOT, METIS_ROOT, YAML_ROOT
# and CMAKE_PREFIX_PATH.
set(MPI_CXX_SKIP_MPICXX ON)
find_package(MPI REQUIRED COMPONENTS CXX)
find_package(OpenMP REQUIRED COMPONENTS CXX)
find_package(OpenSSL 3 REQUIRED COMPONENTS Crypto)
find_package(PkgConfig QUIET)
include(CheckCXXSourceCompiles)

# PETSc is often where only these two variables tell.
foreach(place "$ENV{PETSC_DIR}/$ENV{PETSC_ARCH}" "$ENV{PETSC_DIR}")
  if(IS_DIRECTORY "${place}/lib/pkgconfig")
    set(ENV{PKG_CONFIG_PATH} "$ENV{PKG_CONFIG_PATH}:${place}/lib/pkgconfig")
  endif()
endforeach()

# nanoweft_find(NAME MODULES pkg-config's names HEADER file LIBRARIES names HINTS folders ADVICE text): the imported
# target nanoweft::NAME.
function(nanoweft_find name)
  if(TARGET nanoweft::${name})
    return()
  endif()
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "HEADER;ADVICE" "MODULES;LIBRARIES;HINTS")
  add_library(nanoweft::${name} INTERFACE IMPORTED GLOBAL)
  string(TOUPPER NANOWEFT_${name} key)
  if(PKG_CONFIG_FOUND)
    pkg_search_module(${key} QUIET IMPORTED_TARGET GLOBAL ${arg_MODULES})
  endif()
  if(${key}_FOUND)
    target_link_libraries(nanoweft::${name} INTERFACE PkgConfig::${key})
    return()
  endif()
  find_path(${key}_INCLUDE_DIR ${arg_HEADER} HINTS ${arg_HINTS} PATH_SUFFIXES include)
  find_library(${key}_LIBRARY NAMES ${arg_LIBRARIES} HINTS ${arg_HINTS} PATH_SUFFIXES lib lib64)
  if(NOT ${key}_INCLUDE_DIR OR NOT ${key}_LIBRARY)
    list(JOIN arg_MODULES ", " modules)
    list(JOIN arg_LIBRARIES ", lib" libraries)
    message(FATAL_ERROR "nanoweft: ${name} not found: neither a pkg-config module (${modules}) nor ${arg_HEADER} with "
      "lib${libraries}. ${arg_ADVICE}")
  endif()
  target_include_directories(nanoweft::${name} INTERFACE ${${key}_INCLUDE_DIR})
  target_link_libraries(nanoweft::${name} INTERFACE ${${key}_LIBRARY})
endfunction()

# nanoweft_require(NAME CONDITION TEXT HEADER): what was found must have been configured so.
function(nanoweft_require name condition text header)
  set(CMAKE_REQUIRED_LIBRARIES nanoweft::${name} MPI::MPI_CXX)
  set(CMAKE_REQUIRED_QUIET ON)
  set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
  check_cxx_source_compiles("#include <${header}>\n#if !(${condition})\n#error\n#endif\n" NANOWEFT_GOOD_${name})
  if(NOT NANOWEFT_GOOD_${name})
    unset(NANOWEFT_GOOD_${name} CACHE)
    message(FATAL_ERROR "nanoweft: the ${name} that was found does not serve: nanoweft needs ${text}")
  endif()
endfunction()

# Where one machine has several, HDF5 must be that of the MPI library in use.
if("${MPI_CXX_LIBRARIES}" MATCHES mpich)
  set(hdf5_names hdf5-mpich hdf5_mpich hdf5)
else()
  set(hdf5_names hdf5-openmpi hdf5_openmpi hdf5)
endif()
set(roots $ENV{PETSC_DIR}/$ENV{PETSC_ARCH} $ENV{PETSC_DIR})
nanoweft_find(petsc MODULES PETSc>=3.18 petsc>=3.18 HEADER petsc.h LIBRARIES petsc HINTS ${roots}
  ADVICE "PETSc 3.18 or later: Debian's petsc-dev; elsewhere set PETSC_DIR (and PETSC_ARCH) or PKG_CONFIG_PATH.")
nanoweft_find(hdf5 MODULES ${hdf5_names} HEADER hdf5.h LIBRARIES ${hdf5_names}
  HINTS ${HDF5_ROOT} $ENV{HDF5_ROOT} $ENV{HDF5_DIR} ${roots}
  ADVICE "HDF5 with MPI: Debian's libhdf5-openmpi-dev; elsewhere set HDF5_ROOT or PKG_CONFIG_PATH.")
nanoweft_find(metis MODULES metis HEADER metis.h LIBRARIES metis
  HINTS ${METIS_ROOT} $ENV{METIS_ROOT} $ENV{METIS_DIR} ${roots}
  ADVICE "METIS 5: Debian's libmetis-dev; elsewhere set METIS_ROOT or CMAKE_PREFIX_PATH.")
nanoweft_find(yaml MODULES yaml-0.1 HEADER yaml.h LIBRARIES yaml HINTS ${YAML_ROOT} $ENV{YAML_ROOT} ${roots}
  ADVICE "libyaml 0.2: Debian's libyaml-dev; elsewhere set YAML_ROOT or CMAKE_PREFIX_PATH.")
nanoweft_require(petsc "!defined(PETSC_USE_COMPLEX) && !defined(PETSC_USE_64BIT_INDICES) && defined(PETSC_USE_REAL_DOUBLE)"
  "PETSc with real numbers in double precision and 32-bit indices." petscsys.h)
nanoweft_require(hdf5 "defined(H5_HAVE_PARALLEL)" "HDF5 with MPI (configured with --enable-parallel)." hdf5.h)

set(NANOWEFT_DEPENDENCIES nanoweft::petsc nanoweft::hdf5 OpenSSL::Crypto nanoweft::yaml nanoweft::metis MPI::MPI_CXX
  OpenMP::OpenMP_CXX)
