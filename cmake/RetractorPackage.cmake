# Manual pages, desktop entry, and the Debian packages: "retractor" with the programs, "retractor-dev" with what
# cmake --install gives other projects. ./run package makes both.

set(RETRACTOR_MAINTAINER "Retractor maintainers <maintainers@retractor.invalid>" CACHE STRING
  "Name and address that the Debian packages carry")

# ---- manual pages, from the programs' own --help ----
find_program(HELP2MAN help2man)
if(HELP2MAN)
  set(man_folder "${CMAKE_CURRENT_BINARY_DIR}/man")
  set(documented retractor)
  if(RETRACTOR_WORKSTATION)
    list(APPEND documented retractor-workstation)
  endif()
  list(TRANSFORM documented REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE documented_files)
  add_custom_command(OUTPUT "${man_folder}/retractor.1.gz"
    COMMAND ${CMAKE_COMMAND} -E rm -rf "${man_folder}"
    COMMAND sh "${CMAKE_CURRENT_SOURCE_DIR}/cmake/package/man_pages.sh" ${PROJECT_VERSION} "${man_folder}" ${documented_files}
    DEPENDS ${documented} cmake/package/man_pages.sh VERBATIM COMMENT "Writing manual pages")
  add_custom_target(man_pages ALL DEPENDS "${man_folder}/retractor.1.gz")
  install(DIRECTORY "${man_folder}/" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" COMPONENT programs)
else()
  message(STATUS "help2man is missing: no manual pages are made")
endif()

# ---- what surrounds the programs ----
# Dated as the sources are, by SOURCE_DATE_EPOCH, their commit or their file, not by when they happen to be built.
set(retractor_date_given "$ENV{SOURCE_DATE_EPOCH}")
set(retractor_epoch "${retractor_date_given}")
if(NOT retractor_epoch)
  execute_process(COMMAND git log -1 --format=%ct WORKING_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}"
    OUTPUT_VARIABLE retractor_epoch OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE ignored)
endif()
if(NOT retractor_epoch MATCHES "^[0-9]+$")
  file(TIMESTAMP CMakeLists.txt retractor_epoch "%s" UTC)
endif()
set(ENV{SOURCE_DATE_EPOCH} "${retractor_epoch}") # which string(TIMESTAMP) takes for the current time
string(TIMESTAMP retractor_date "%a, %d %b %Y %H:%M:%S +0000" UTC)
configure_file(cmake/package/changelog.in "${CMAKE_CURRENT_BINARY_DIR}/changelog" @ONLY)
set(ENV{SOURCE_DATE_EPOCH} "${retractor_date_given}")
find_program(GZIP gzip REQUIRED)
execute_process(COMMAND ${GZIP} -9nf "${CMAKE_CURRENT_BINARY_DIR}/changelog" COMMAND_ERROR_IS_FATAL ANY)
install(FILES README.md LICENSE DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT programs)
install(DIRECTORY docs DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT programs
  FILES_MATCHING PATTERN "*.md" PATTERN "*.png")
foreach(folder mesh fem datasets haptics planner ui) # docs/developer/architecture.md names their pages
  install(FILES ${folder}/README.md DESTINATION "${CMAKE_INSTALL_DOCDIR}/${folder}" COMPONENT programs)
endforeach()
install(FILES cmake/package/copyright "${CMAKE_CURRENT_BINARY_DIR}/changelog.gz"
  DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/retractor" COMPONENT programs)
install(FILES cmake/package/copyright "${CMAKE_CURRENT_BINARY_DIR}/changelog.gz"
  DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/retractor-dev" COMPONENT development)
if(RETRACTOR_WORKSTATION)
  install(FILES cmake/package/retractor-workstation.desktop DESTINATION "${CMAKE_INSTALL_DATADIR}/applications"
    COMPONENT programs)
  install(FILES cmake/package/retractor.svg DESTINATION "${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps"
    COMPONENT programs)
endif()

# ---- Debian packages ----
set(CPACK_GENERATOR DEB)
# gzip makes packages a quarter larger than xz, in a third of the time.
set(CPACK_DEBIAN_COMPRESSION_TYPE gzip)
set(CPACK_PACKAGE_NAME retractor)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "${RETRACTOR_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL programs development)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME retractor)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
# libcholmod3 is content with the reference BLAS, which is ten times slower; the drivers are loaded at run time.
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS "libopenblas0, libegl-mesa0, libgl1-mesa-dri")
# For a window in Japanese: its font, and the words of the dialogs that Qt brings along.
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS "fonts-noto-cjk, qttranslations5-l10n")
# The first line of a description is the project's own.
set(CPACK_DEBIAN_PROGRAMS_DESCRIPTION "Retractor draws an incision on the skin, cuts the chest wall, pulls the wound
open with hooks, looks through it at the target, and says in numbers and
pictures what the surgeon would see: retractor on the command line,
retractor-workstation in a window.
.
Research software, not a medical device.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME retractor-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
string(JOIN ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  libarchive-dev libbz2-dev libcgal-dev libdcmtk-dev libeigen3-dev libembree-dev libgdcm-dev libinsighttoolkit5-dev libmetis-dev libopenblas-dev libssl-dev
  libsqlite3-dev libsuitesparse-dev libtbb-dev libvtk-dicom-dev libvtk9-dev nlohmann-json3-dev zlib1g-dev)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "Static libraries, headers and CMake package file of Retractor: volumes, labels
and tetrahedral meshes, cutting, finite elements, planning.")
include(CPack)
