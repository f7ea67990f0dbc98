/* What bindgen reads. By bare name: the headers live in coin/ or coin-or/, and pkg-config says where. */
#include "IpStdCInterface.h"
#include "IpoptConfig.h"
#include "shim.h"
