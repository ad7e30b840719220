# Flags shared by every target.
#
# vergence_flags: warnings are errors; -ffp-contract=off because a fused multiply-add rounds once where two
# operations round twice, and results must be the same bits on every processor.
# vergence_controller_flags: what is linked into the controller knows neither exceptions nor run-time types, and
# Eigen's own vector code is off (on arm64 it would fuse); our vector code is written out, with Highway.
add_library(vergence_flags INTERFACE)
target_compile_options(vergence_flags INTERFACE -Wall -Wextra -Wconversion -Wshadow -Wzero-as-null-pointer-constant -Werror -ffp-contract=off)
target_include_directories(vergence_flags INTERFACE ${PROJECT_SOURCE_DIR})
# The least processor: SSE4.2 (any x86-64 since 2009). Highway adds AVX2 and AVX-512 beside it, chosen at run time.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(vergence_flags INTERFACE -march=x86-64-v2)
  # Otherwise Highway's SSE4 asks for AES as well, which that level does not promise.
  target_compile_definitions(vergence_flags INTERFACE HWY_DISABLE_PCLMUL_AES)
endif()
# On arm64, NEON alone: every processor of it has that, and nobody has measured that SVE pays here.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
  target_compile_definitions(vergence_flags INTERFACE "HWY_DISABLED_TARGETS=(HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128)")
endif()

find_package(Eigen3 3.4 REQUIRED NO_MODULE)
get_target_property(VERGENCE_EIGEN_INCLUDE Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
target_include_directories(vergence_flags SYSTEM INTERFACE ${VERGENCE_EIGEN_INCLUDE})
target_compile_definitions(vergence_flags INTERFACE EIGEN_DONT_VECTORIZE EIGEN_MAX_ALIGN_BYTES=16)

add_library(vergence_controller_flags INTERFACE)
target_link_libraries(vergence_controller_flags INTERFACE vergence_flags)
target_compile_options(vergence_controller_flags INTERFACE -fno-exceptions -fno-rtti)
