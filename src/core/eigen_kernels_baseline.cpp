#define ABERFIT_ISA baseline
#define Eigen aberfit_eigen_baseline
#include "eigen_kernels.inc"
