# The part of dlib that finds keypoints: headers alone, and BLAS, which Debian's dlib is configured to call. dlib's own package would bring
# libraries for pictures and databases along.
#
# Defines the target DlibKeypoints::keypoints and DlibKeypoints_FOUND. Set DlibKeypoints_ROOT to look in one place first.

find_path(DlibKeypoints_INCLUDE_DIR dlib/image_keypoint.h)
find_package(BLAS QUIET)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(
  DlibKeypoints
  REQUIRED_VARS DlibKeypoints_INCLUDE_DIR BLAS_FOUND
  REASON_FAILURE_MESSAGE "install dlib (Debian: libdlib-dev) or set DlibKeypoints_ROOT")
mark_as_advanced(DlibKeypoints_INCLUDE_DIR)

if(DlibKeypoints_FOUND AND NOT TARGET DlibKeypoints::keypoints)
  add_library(DlibKeypoints::keypoints INTERFACE IMPORTED)
  set_target_properties(DlibKeypoints::keypoints PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${DlibKeypoints_INCLUDE_DIR}" INTERFACE_LINK_LIBRARIES BLAS::BLAS)
endif()
