# Installs into an empty folder, then configures, builds and runs the outside project against it, and nothing else; then
# the same for the example of the documents, for a program that cuts and solves, for the floor that needs every library,
# and for a front end to live surgery.

function(step)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGV}\nfailed (${result}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# build_and_run(folder [program]): the program has the name of its folder unless another is given.
function(build_and_run source)
  cmake_path(GET source FILENAME name)
  set(program ${name})
  if(ARGC GREATER 1)
    set(program ${ARGV1})
  endif()
  step(${CMAKE_COMMAND} -G ${GENERATOR} -S "${source}" -B "${WORK_FOLDER}/build-${name}" -D CMAKE_BUILD_TYPE=Release
    -D "CMAKE_PREFIX_PATH=${WORK_FOLDER}/prefix" -D CMAKE_C_COMPILER=${C} -D CMAKE_CXX_COMPILER=${CXX})
  step(${CMAKE_COMMAND} --build "${WORK_FOLDER}/build-${name}")
  step("${WORK_FOLDER}/build-${name}/${program}" "${WORK_FOLDER}")
  message(STATUS "${output}")
endfunction()

file(REMOVE_RECURSE "${WORK_FOLDER}")
step(${CMAKE_COMMAND} --install "${BUILD_FOLDER}" --prefix "${WORK_FOLDER}/prefix")
build_and_run("${SOURCE_FOLDER}/outside")
build_and_run("${SOURCE_FOLDER}/outside_cutter" mine)
build_and_run("${SOURCE_FOLDER}/outside_solver")
build_and_run("${SOURCE_FOLDER}/outside_planner")
build_and_run("${SOURCE_FOLDER}/outside_session")
file(REMOVE_RECURSE "${WORK_FOLDER}/prefix") # 40 MB
