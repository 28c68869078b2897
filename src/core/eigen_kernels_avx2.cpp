#define ABERFIT_ISA avx2
#define Eigen aberfit_eigen_avx2
#include "eigen_kernels.inc"
