# The core and imgproc modules of OpenCV, which Debian's libopencv-imgproc-dev ships without a CMake package.
#
# Defines the target OpenCVImgproc::imgproc, OpenCVImgproc::features2d where that is installed too (libopencv-features2d-dev), and OpenCVImgproc_FOUND, OpenCVImgproc_VERSION. Set OpenCVImgproc_ROOT to look in one
# place first.

find_path(OpenCVImgproc_INCLUDE_DIR opencv2/imgproc.hpp PATH_SUFFIXES opencv4)
find_library(OpenCVImgproc_CORE_LIBRARY opencv_core)
find_library(OpenCVImgproc_LIBRARY opencv_imgproc)
find_library(OpenCVImgproc_FEATURES2D_LIBRARY opencv_features2d)

if(OpenCVImgproc_INCLUDE_DIR)
  file(STRINGS "${OpenCVImgproc_INCLUDE_DIR}/opencv2/core/version.hpp" opencv_version_lines REGEX "#define CV_VERSION_(MAJOR|MINOR|REVISION)[ \t]+[0-9]+")
  string(REGEX REPLACE "[^;]*[ \t]([0-9]+)[^;0-9]*" "\\1" opencv_version_numbers "${opencv_version_lines}")
  list(JOIN opencv_version_numbers "." OpenCVImgproc_VERSION)
  unset(opencv_version_lines)
  unset(opencv_version_numbers)
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(
  OpenCVImgproc
  REQUIRED_VARS OpenCVImgproc_LIBRARY OpenCVImgproc_CORE_LIBRARY OpenCVImgproc_INCLUDE_DIR
  VERSION_VAR OpenCVImgproc_VERSION
  REASON_FAILURE_MESSAGE "install OpenCV (Debian: libopencv-imgproc-dev) or set OpenCVImgproc_ROOT")
mark_as_advanced(OpenCVImgproc_INCLUDE_DIR OpenCVImgproc_CORE_LIBRARY OpenCVImgproc_LIBRARY OpenCVImgproc_FEATURES2D_LIBRARY)

if(OpenCVImgproc_FOUND AND NOT TARGET OpenCVImgproc::imgproc)
  add_library(OpenCVImgproc::core UNKNOWN IMPORTED)
  set_target_properties(OpenCVImgproc::core PROPERTIES IMPORTED_LOCATION "${OpenCVImgproc_CORE_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${OpenCVImgproc_INCLUDE_DIR}")
  add_library(OpenCVImgproc::imgproc UNKNOWN IMPORTED)
  set_target_properties(OpenCVImgproc::imgproc PROPERTIES IMPORTED_LOCATION "${OpenCVImgproc_LIBRARY}" INTERFACE_LINK_LIBRARIES OpenCVImgproc::core)
  if(OpenCVImgproc_FEATURES2D_LIBRARY)
    add_library(OpenCVImgproc::features2d UNKNOWN IMPORTED)
    set_target_properties(OpenCVImgproc::features2d PROPERTIES IMPORTED_LOCATION "${OpenCVImgproc_FEATURES2D_LIBRARY}" INTERFACE_LINK_LIBRARIES OpenCVImgproc::imgproc)
  endif()
endif()
