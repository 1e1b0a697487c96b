# The headers that most sources include, parsed once per kind of target. Only the release preset asks for it: in the
# others a source that forgets an include does not compile.

option(RETRACTOR_PRECOMPILED_HEADERS "Parse the standard library, Eigen, GoogleTest and CLI11 once" OFF)

set(retractor_common_headers
  <Eigen/Core> <Eigen/Geometry>
  <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <cstdio> <filesystem> <fstream> <functional> <limits> <map>
  <memory> <numbers> <optional> <random> <set> <span> <sstream> <string> <string_view> <thread> <utility> <vector>)

# retractor_precompiled(name header...): a target for others to take these from.
function(retractor_precompiled name)
  set(source "${CMAKE_BINARY_DIR}/${name}.cpp")
  file(CONFIGURE OUTPUT "${source}" CONTENT "// The precompiled headers need a source.\n")
  add_library(${name} OBJECT "${source}")
  target_link_libraries(${name} PRIVATE retractor_options)
  target_precompile_headers(${name} PRIVATE ${ARGN})
endfunction()

# Gives them to every target below this directory that has the flags they were parsed with.
function(retractor_reuse_precompiled directory)
  get_property(targets DIRECTORY "${directory}" PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    get_target_property(refused ${target} DISABLE_PRECOMPILE_HEADERS)
    get_target_property(own ${target} PRECOMPILE_HEADERS)
    if(type MATCHES "^(STATIC_LIBRARY|EXECUTABLE)$" AND NOT refused AND NOT own)
      get_target_property(libraries ${target} LINK_LIBRARIES)
      if("GTest::gtest" IN_LIST libraries)
        target_precompile_headers(${target} REUSE_FROM precompiled_tests)
      else()
        target_precompile_headers(${target} REUSE_FROM precompiled_common)
      endif()
    endif()
  endforeach()
  get_property(folders DIRECTORY "${directory}" PROPERTY SUBDIRECTORIES)
  foreach(folder ${folders})
    retractor_reuse_precompiled("${folder}")
  endforeach()
endfunction()

# After all targets are made.
function(retractor_precompile)
  # These need more, or have other flags (Qt's position independence).
  target_precompile_headers(retractor_cli PRIVATE ${retractor_common_headers} <CLI/CLI.hpp> <nlohmann/json.hpp>)
  if(RETRACTOR_WORKSTATION)
    target_precompile_headers(retractor_window PRIVATE ${retractor_common_headers})
  endif()
  retractor_precompiled(precompiled_common ${retractor_common_headers})
  if(RETRACTOR_TESTS)
    find_package(GTest REQUIRED) # known in tests/ alone
    retractor_precompiled(precompiled_tests ${retractor_common_headers} <gtest/gtest.h>)
    target_link_libraries(precompiled_tests PRIVATE GTest::gtest)
  endif()
  retractor_reuse_precompiled("${CMAKE_SOURCE_DIR}")
endfunction()
