# The target "docs": API pages by Doxygen over the public headers, where Doxygen is found; into docs/ of the build folder.

find_package(Doxygen OPTIONAL_COMPONENTS dot)
if(DOXYGEN_FOUND)
  add_custom_target(docs
    COMMAND ${CMAKE_COMMAND} -E env "RETRACTOR_DOCS_OUTPUT=${CMAKE_BINARY_DIR}/docs" "RETRACTOR_VERSION=${PROJECT_VERSION}"
      $<TARGET_FILE:Doxygen::doxygen> docs/Doxyfile
    WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}" VERBATIM COMMENT "Writing API pages")
endif()
