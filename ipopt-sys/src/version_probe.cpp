/* Preprocessed by the build script, which reads the version out of the line below. */
#include "IpoptConfig.h"
ipopt_sys_version IPOPT_VERSION_MAJOR IPOPT_VERSION_MINOR IPOPT_VERSION_RELEASE
