# The Debian package: `cpack --config build/release/CPackConfig.cmake -B FOLDER` in any build folder, whatever its prefix. What
# the install rules leave lies under /usr; the scripts beside this file add what Debian's policy asks for. Packed
# twice, a build gives the same bytes: package_time.cmake sets the time they are stamped with.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "The tribotrack authors")
set(CPACK_PACKAGE_DIRECTORY "${PROJECT_BINARY_DIR}/package")
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_STRIP_FILES ON)
# Rules that write elsewhere than below the prefix are of no use to a package; with DESTDIR they see the prefix that it has.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_PROJECT_CONFIG_FILE "${CMAKE_CURRENT_LIST_DIR}/package_time.cmake")
set(CPACK_PRE_BUILD_SCRIPTS "${CMAKE_CURRENT_LIST_DIR}/package_documents.cmake")
set(CPACK_TRIBOTRACK_SOURCE "${PROJECT_SOURCE_DIR}")

set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${TRIBOTRACK_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "friction parameters of vibrated parts from high-speed video")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "A part on a vibrating platform is tracked in high-speed recordings with a
standard deviation for every position; its dry friction, nominal and lowered
by an actuator, is fitted to where it goes, with an interval for every
parameter and a report of one page.

This package holds the program tribotrack, the module tribotrack for Python,
and the C++ libraries of both with headers and CMake's files.")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA "${CMAKE_CURRENT_LIST_DIR}/postinst;${CMAKE_CURRENT_LIST_DIR}/prerm")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

foreach(name IN ITEMS Python3_VERSION_MAJOR Python3_VERSION_MINOR)
  get_directory_property(${name} DIRECTORY "${PROJECT_SOURCE_DIR}/apps/python" DEFINITION ${name})
endforeach()

foreach(name IN ITEMS OpenCV_VERSION_MAJOR OpenCV_VERSION_MINOR)
  get_directory_property(${name} DIRECTORY "${PROJECT_SOURCE_DIR}/vision" DEFINITION ${name})
endforeach()
# dpkg-shlibdeps finds what is linked. Loaded when a file needs it (vision/io/picture_files.cpp):
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
math(EXPR imgcodecs "100 * ${OpenCV_VERSION_MAJOR} + ${OpenCV_VERSION_MINOR}")
set(CPACK_DEBIAN_PACKAGE_DEPENDS "libopencv-imgcodecs${imgcodecs}")
# Figures for print; the module, which is for one version of Python.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS python3-matplotlib)
if(TARGET tribotrack_python)
  math(EXPR next "${Python3_VERSION_MINOR} + 1")
  string(APPEND CPACK_DEBIAN_PACKAGE_RECOMMENDS ", python3-numpy, python3 (>= ${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR})"
    ", python3 (<< ${Python3_VERSION_MAJOR}.${next})")
endif()
# To link the libraries (tribotrackConfig.cmake.in).
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "cmake, g++, libavformat-dev, libceres-dev, libeigen3-dev, libfmt-dev, libopencv-dev")
include(CPack)
