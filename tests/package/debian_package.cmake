# The Debian package as a user gets it: made, looked into, unpacked and run.

function(step)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE error)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGV}\nfailed (${result}):\n${output}${error}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(expect text)
  foreach(part ${ARGN})
    string(FIND "${text}" "${part}" at)
    if(at EQUAL -1)
      message(SEND_ERROR "\"${part}\" is missing in:\n${text}")
    endif()
  endforeach()
endfunction()

file(REMOVE_RECURSE "${WORK_FOLDER}")
step(${CPACK} --config "${BUILD_FOLDER}/CPackConfig.cmake" -B "${WORK_FOLDER}")
file(GLOB package "${WORK_FOLDER}/retractor_*.deb")

step(dpkg-deb --field "${package}" Depends)
# OpenBLAS is named by us, the others are found by dpkg-shlibdeps; the drivers are loaded at run time.
expect("${output}" libopenblas0 libgl1-mesa-dri libegl-mesa0 libcholmod3 libosmesa6 libegl1 libvtk9.1 libvtkdicom0.8
  libinsighttoolkit5.2 libembree3-3 libtbb12 libssl3)
step(dpkg-deb --contents "${package}")
expect("${output}" ./usr/bin/retractor\n ./usr/bin/retractor-egl\n ./usr/share/doc/retractor/copyright
  ./usr/share/doc/retractor/README.md ./usr/share/doc/retractor/planner/README.md
  ./usr/share/man/man1/retractor.1.gz ./usr/share/man/man1/retractor-plan.1.gz)
if(WORKSTATION)
  expect("${output}" ./usr/bin/retractor-workstation ./usr/share/applications/retractor-workstation.desktop
    ./usr/share/man/man1/retractor-workstation.1.gz)
endif()

step(dpkg-deb --extract "${package}" "${WORK_FOLDER}/root")
set(retractor "${WORK_FOLDER}/root/usr/bin/retractor")
step(${retractor} phantom block --nrrd --out "${WORK_FOLDER}/patient")
step(${retractor} import "${WORK_FOLDER}/patient/ct.nrrd" --labels "${WORK_FOLDER}/patient/labels.nrrd"
  --out "${WORK_FOLDER}/patient/case.json")
step(${retractor} approach add "${WORK_FOLDER}/patient/case.json" --name straight --points 1.3,0,-25 0.9,0,0 1.3,0,25
  --target target --retract cavity --hooks 2 --opening 20)
# Both executables draw, each with its own kind of context.
foreach(backend osmesa egl)
  step(${retractor} render "${WORK_FOLDER}/patient/case.json" --views overview --size 320x240 --backend ${backend}
    --out "${WORK_FOLDER}/${backend}")
  file(GLOB pictures "${WORK_FOLDER}/${backend}/*.png")
  if(NOT pictures)
    message(SEND_ERROR "no picture by ${backend}")
  endif()
endforeach()
file(GLOB leftovers "${WORK_FOLDER}/_CPack_Packages" "${WORK_FOLDER}/root")
file(REMOVE_RECURSE ${leftovers})
