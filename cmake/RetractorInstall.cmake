# cmake --install: libraries with headers and a package file for other projects (component "development"), programs
# with their manual pages (component "programs").
#
#   find_package(retractor REQUIRED COMPONENTS mesh fem)  ->  retractor::mesh, retractor::fem

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(RETRACTOR_INSTALLED_FOLDERS mesh fem datasets haptics planner)
# Headers lie in the folder of their sources: those of mesh_io in mesh, those of session in planner/session.
set(RETRACTOR_COMPONENTS mesh mesh_io mesh_generation fem elastic_model datasets haptics hand planner_case planner session)
set(retractor_package_folder "${CMAKE_INSTALL_LIBDIR}/cmake/retractor")

# What the static libraries need from VTK and ITK is asked of their targets, so that the package file cannot fall behind.
foreach(component ${RETRACTOR_COMPONENTS})
  get_target_property(libraries retractor_${component} LINK_LIBRARIES)
  list(FILTER libraries INCLUDE REGEX "^VTK::")
  list(REMOVE_ITEM libraries VTK::DICOM)
  list(TRANSFORM libraries REPLACE "^VTK::" "")
  set(RETRACTOR_VTK_${component} "${libraries}")
endforeach()
get_directory_property(RETRACTOR_ITK_datasets DIRECTORY datasets DEFINITION ITK_MODULES_REQUESTED)

set(exported_targets retractor_options)
foreach(component ${RETRACTOR_COMPONENTS})
  set_target_properties(retractor_${component} PROPERTIES EXPORT_NAME ${component})
  list(APPEND exported_targets retractor_${component})
endforeach()
foreach(folder ${RETRACTOR_INSTALLED_FOLDERS})
  # The headers' own paths ("mesh/cutting/cut_session.h") stay what they are, below a folder of ours.
  install(DIRECTORY ${folder} DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/retractor" COMPONENT development
    FILES_MATCHING PATTERN "*.h"
    PATTERN "planner/evidence" EXCLUDE # these two belong to a command, and to no exported library
    PATTERN "datasets/tables" EXCLUDE)
endforeach()
set_target_properties(retractor_options PROPERTIES EXPORT_NAME options)
target_include_directories(retractor_options INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/retractor>)
install(TARGETS ${exported_targets} EXPORT retractorTargets
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development)
install(EXPORT retractorTargets NAMESPACE retractor:: DESTINATION "${retractor_package_folder}" COMPONENT development)

configure_package_config_file(cmake/retractorConfig.cmake.in "${CMAKE_CURRENT_BINARY_DIR}/retractorConfig.cmake"
  INSTALL_DESTINATION "${retractor_package_folder}")
write_basic_package_version_file("${CMAKE_CURRENT_BINARY_DIR}/retractorConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES
  "${CMAKE_CURRENT_BINARY_DIR}/retractorConfig.cmake" "${CMAKE_CURRENT_BINARY_DIR}/retractorConfigVersion.cmake"
  cmake/FindCHOLMOD.cmake
  DESTINATION "${retractor_package_folder}" COMPONENT development)

set(programs retractor retractor-egl)
if(RETRACTOR_WORKSTATION)
  list(APPEND programs retractor-workstation)
endif()
install(TARGETS ${programs} RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT programs)
