# SPDX-License-Identifier: BSD-3-Clause
# CPack runs this when the packages' files are in place, in a folder for each component. It adds copyright and
# changelog, compresses manual pages, and gives all files the time SOURCE_DATE_EPOCH.
set(epoch "$ENV{SOURCE_DATE_EPOCH}")
if(NOT epoch MATCHES "^[0-9]+$")
  message(FATAL_ERROR "SOURCE_DATE_EPOCH is not set: ./dev package sets it to the time of the last commit")
endif()
execute_process(COMMAND date --utc --rfc-email "--date=@${epoch}" OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
file(READ "${CPACK_KDSTREAM_SOURCE}/LICENSE" licence)
string(REGEX MATCH "Copyright[^\n]*" holder "${licence}")
string(REGEX REPLACE ".*All rights reserved.\n\n" "" licence "${licence}")
string(REGEX REPLACE "\n$" "" licence "${licence}")
string(REPLACE "\n\n" "\n.\n" licence "${licence}")
string(REPLACE "\n" "\n " licence "${licence}")
string(REGEX REPLACE "Copyright \\(c\\) " "" holder "${holder}")

foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER "${component}" key)
  set(package "${CPACK_DEBIAN_${key}_PACKAGE_NAME}")
  set(root "${CPACK_TEMPORARY_DIRECTORY}/${component}")
  set(folder "${root}/usr/share/doc/${package}")
  file(WRITE "${folder}/copyright"
    "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: KdStream\n\n"
    "Files: *\nCopyright: ${holder}\nLicense: BSD-3-clause\n ${licence}\n")
  file(WRITE "${folder}/changelog.Debian"
    "kdstream (${CPACK_KDSTREAM_VERSION}) unstable; urgency=medium\n\n  * What changed for users: CHANGELOG.md, in the package kdstream-doc.\n\n"
    " -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  file(GLOB pages "${root}/usr/share/man/man*/*.[0-9]")
  execute_process(COMMAND gzip --best --no-name "${folder}/changelog.Debian" ${pages} COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND find "${root}" -type d -exec chmod 755 {} + COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND find "${root}" -exec touch --no-dereference "--date=@${epoch}" {} + COMMAND_ERROR_IS_FATAL ANY)
endforeach()
