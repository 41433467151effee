# cmake -DCOMMANDS=compile_commands.json -P no_opencv_folder.cmake
file(READ "${COMMANDS}" commands)
if(NOT commands MATCHES "eigen3")
  message(SEND_ERROR "${COMMANDS} names no folder of Eigen: nothing was read")
endif()
if(commands MATCHES "opencv")
  message(SEND_ERROR "a folder of OpenCV in ${COMMANDS}")
endif()
