# CHOLMOD (SuiteSparse) with METIS ordering, over OpenBLAS: Debian's SuiteSparse 5 has no CMake package file, and
# libcholmod alone is content with the reference BLAS, which is ten times slower. OpenBLAS is named first, so that its
# symbols are the ones the dynamic linker binds.
#
#   find_package(CHOLMOD REQUIRED)  ->  imported target CHOLMOD::CHOLMOD

find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(CHOLMOD_LIBRARY cholmod)
find_library(SUITESPARSECONFIG_LIBRARY suitesparseconfig) # holds its allocation functions
find_path(OPENBLAS_INCLUDE_DIR cblas.h PATH_SUFFIXES openblas-pthread openblas NO_CMAKE_PATH
  PATHS /usr/include/x86_64-linux-gnu /usr/include/aarch64-linux-gnu)
find_library(OPENBLAS_LIBRARY openblas)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(CHOLMOD
  REQUIRED_VARS CHOLMOD_LIBRARY SUITESPARSECONFIG_LIBRARY CHOLMOD_INCLUDE_DIR OPENBLAS_LIBRARY OPENBLAS_INCLUDE_DIR)

if(CHOLMOD_FOUND AND NOT TARGET CHOLMOD::CHOLMOD)
  add_library(CHOLMOD::CHOLMOD INTERFACE IMPORTED)
  set_target_properties(CHOLMOD::CHOLMOD PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${CHOLMOD_INCLUDE_DIR};${OPENBLAS_INCLUDE_DIR}"
    INTERFACE_LINK_LIBRARIES "${OPENBLAS_LIBRARY};${CHOLMOD_LIBRARY};${SUITESPARSECONFIG_LIBRARY}")
endif()
mark_as_advanced(CHOLMOD_INCLUDE_DIR CHOLMOD_LIBRARY SUITESPARSECONFIG_LIBRARY OPENBLAS_INCLUDE_DIR OPENBLAS_LIBRARY)
