# Writes the tests of a GoogleTest program for ctest, one a suite: starting a program costs more than most of its tests,
# and a suite sets up its patient once. CMake's gtest_discover_tests starts a program for every test.
#   cmake -D PROGRAM=bin/mesh_tests -D PREFIX= -D LIMIT=600 -D OUT=mesh_tests.cmake -P list_suites.cmake
execute_process(COMMAND "${PROGRAM}" --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY TIMEOUT 60)
string(REGEX MATCHALL "[^\n]+" lines "${listed}")
# Skipped only where no test of the suite failed: then nothing stands below the last test that was skipped.
set(skipped [[\\[  SKIPPED \\] [^\n]+\n*$]])
set(text "")
foreach(line IN LISTS lines)
  if(line MATCHES [[^([^ ]+)\.( |$)]])
    set(suite "${CMAKE_MATCH_1}")
    string(APPEND text "add_test([=[${PREFIX}${suite}]=] \"${PROGRAM}\" \"--gtest_filter=${suite}.*\")\n"
      "set_tests_properties([=[${PREFIX}${suite}]=] PROPERTIES TIMEOUT ${LIMIT} SKIP_REGULAR_EXPRESSION \"${skipped}\")\n")
  endif()
endforeach()
if(text STREQUAL "")
  message(FATAL_ERROR "${PROGRAM} lists no tests")
endif()
file(WRITE "${OUT}" "${text}")
