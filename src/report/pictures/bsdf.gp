# title: Scatter function
# caption: Bidirectional scatter distribution over the angle from the specular direction, at normal incidence.
#   One curve is for the whole specification. The other is for the part that no term carries; ray tracers use
#   it as scatter model beside the terms.
# alt: BSDF over scatter angle of the whole specification and of the part that no term carries.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 800
load 'common.gp'

set title head('Scatter function of the mirror')
eval x_axis; eval y_axis
set xlabel 'angle from the reflected direction [degrees]'; set ylabel 'BSDF [1/sr]'
set key bottom left inside vertical
degree = 180/pi
plot for [i=1:has_whole] 'bsdf_whole.dat' using ($1 > 0 ? $1*degree : NaN):2 with lines linetype 2 \
    title 'whole specification'.whole_text, \
  for [i=1:has_rest] 'bsdf_rest.dat' using ($1 > 0 ? $1*degree : NaN):2 with lines linetype 3 \
    title rest_label.rest_text
