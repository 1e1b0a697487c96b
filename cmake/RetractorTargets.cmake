# How this project's libraries are made: static, each with an alias, warnings and precompiled headers.

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Threads REQUIRED)

# One interface target carries language level, warnings and Eigen's settings, so that they never differ between targets.
add_library(retractor_options INTERFACE)
target_compile_features(retractor_options INTERFACE cxx_std_20)
# Warnings and sanitizers are ours alone: whoever uses the installed libraries has their own.
set(retractor_warnings
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wnon-virtual-dtor -Woverloaded-virtual -Werror
  # GCC 12 warns falsely of "text" + std::string and of moved strings (its bugs 105651 and 105329); with precompiled
  # headers it no longer knows that the place is in a system header. It also guesses wrongly, differently at each level of
  # optimisation, that members of std::optional and std::function are read before they are set.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict$<SEMICOLON>-Wno-stringop-overflow$<SEMICOLON>-Wno-array-bounds>
  $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
target_compile_options(retractor_options INTERFACE "$<BUILD_INTERFACE:${retractor_warnings}>")
# GCC collects its garbage from 128 MB on. From 1 GB (kB here) it hardly ever does, and compiles in a tenth less time with
# 100 MB more.
target_compile_options(retractor_options INTERFACE
  "$<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1048576>>")
# GNU's gold, a part of Debian 12's binutils, links `retractor` in a fifth of the time of GNU's ld.
include(CheckLinkerFlag)
check_linker_flag(CXX -fuse-ld=gold RETRACTOR_GOLD)
if(RETRACTOR_GOLD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_link_options(retractor_options INTERFACE "$<BUILD_INTERFACE:-fuse-ld=gold>")
endif()
target_include_directories(retractor_options INTERFACE "$<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>")
target_link_libraries(retractor_options INTERFACE Eigen3::Eigen Threads::Threads)
if(RETRACTOR_ASSERTIONS)
  target_compile_definitions(retractor_options INTERFACE $<BUILD_INTERFACE:RETRACTOR_ASSERTIONS>)
endif()
if(RETRACTOR_SANITIZE)
  target_compile_options(retractor_options INTERFACE
    "$<BUILD_INTERFACE:-fsanitize=${RETRACTOR_SANITIZE};-fno-omit-frame-pointer>")
  target_link_options(retractor_options INTERFACE "$<BUILD_INTERFACE:-fsanitize=${RETRACTOR_SANITIZE}>")
endif()

# Headers that most sources include, compiled once for all targets that name them. A source still includes what it uses.
set(retractor_precompiled_standard
  <algorithm> <array> <cmath> <cstdint> <cstdio> <filesystem> <fstream> <functional> <limits> <map> <memory> <numbers> <optional>
  <set> <span> <sstream> <string> <string_view> <utility> <vector>)
set(retractor_precompiled_eigen <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU>)

# retractor_compile_fast(target...): sources that read options, write JSON or test are compiled in half the time with -O1;
# nothing in them is worth optimising. What measures or computes keeps the build type's own level.
function(retractor_compile_fast)
  foreach(target ${ARGN})
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endforeach()
endfunction()

# retractor_precompiled(numerics <vector> ...): a target that compiles these headers once. Another target of the same
# compile options takes them by target_precompile_headers(other REUSE_FROM retractor_precompiled_numerics).
function(retractor_precompiled name)
  set(source "${CMAKE_BINARY_DIR}/precompiled/${name}.cpp")
  file(CONFIGURE OUTPUT "${source}" CONTENT "// The headers of retractor_precompiled_${name} are compiled with this source.\n")
  add_library(retractor_precompiled_${name} OBJECT "${source}")
  target_link_libraries(retractor_precompiled_${name} PRIVATE retractor_options)
  target_precompile_headers(retractor_precompiled_${name} PRIVATE ${ARGN})
endfunction()
retractor_precompiled(standard ${retractor_precompiled_standard})
retractor_precompiled(numerics ${retractor_precompiled_standard} ${retractor_precompiled_eigen})

# retractor_library(mesh [PRECOMPILED numerics] a.cpp b.cpp ...): static library retractor_mesh with the alias
# retractor::mesh and the precompiled headers of that name.
function(retractor_library name)
  cmake_parse_arguments(PARSE_ARGV 1 library "" "PRECOMPILED" "")
  if(NOT library_PRECOMPILED)
    set(library_PRECOMPILED numerics)
  endif()
  add_library(retractor_${name} STATIC ${library_UNPARSED_ARGUMENTS})
  add_library(retractor::${name} ALIAS retractor_${name})
  target_link_libraries(retractor_${name} PUBLIC retractor_options)
  target_precompile_headers(retractor_${name} REUSE_FROM retractor_precompiled_${library_PRECOMPILED})
endfunction()

# retractor_link_external(target lib...): headers of other projects are not held to our warnings.
function(retractor_link_external target)
  foreach(library ${ARGN})
    target_link_libraries(${target} PRIVATE ${library})
    get_target_property(directories ${library} INTERFACE_INCLUDE_DIRECTORIES)
    if(directories)
      target_include_directories(${target} SYSTEM PRIVATE ${directories})
    endif()
  endforeach()
endfunction()
