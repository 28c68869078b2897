#define ABERFIT_ISA avx512
#define Eigen aberfit_eigen_avx512
#include "eigen_kernels.inc"
