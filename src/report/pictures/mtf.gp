# title: Modulation transfer function
# caption: Contrast of a sinusoidal pattern in the focus over its frequency, up to the cutoff of the aperture.
#   Lines of ideal mirror and fitted surface are means over directions; the band reaches from the worst
#   direction of the fitted surface to its best. An equivalent surface follows the target.
# alt: Modulation transfer function of ideal mirror, target and fitted surface over spatial frequency.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 800
load 'common.gp'

set title head('Modulation transfer at z = f')
set xlabel 'spatial frequency in the focal plane [cycles/mm]'; set ylabel 'modulation transfer'
set xrange [0:last*1e-3]; set yrange [0:1.02]; set ytics 0.1
set key inside top right vertical
plot for [i=1:has_fitted] 'mtf.dat' using ($1*1e-3):5:6 with filledcurves fillcolor rgb '#f7ddcc' \
    title 'fitted surface, all directions', \
  for [k in curves] 'mtf.dat' using ($1*1e-3):(column(k+1)) with lines linetype (k+0) title surface[k+0]
