# SPDX-License-Identifier: GPL-3.0-or-later
# A Debian package: cpack -G DEB in the build folder. It depends on the libraries that the program was linked with.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME crackle)
set(CPACK_PACKAGE_CONTACT "crackle's maintainers <crackle@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# What starts the ranks; and, for the report, Python with its packages.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "openmpi-bin")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS
    "python3, python3-h5py, python3-numpy, python3-matplotlib, python3-pil, python3-scipy, python3-pandas, python3-xarray, libjs-three")
include(CPack)
