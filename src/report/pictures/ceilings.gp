# title: How rough the mirror may be
# caption: Largest level of the profile PSD that one octave of frequencies may have if all others are smooth,
#   and straight lines A/f^B that may be used over the whole band (as in ISO 10110-8). Octaves cannot all be
#   at their ceiling together; a line can be specified as it is.
# alt: Ceilings of the one-sided profile PSD over spatial frequency.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1000; height = 750
load 'common.gp'

set title head(bounds)
eval f_axis
eval l_axis
set xlabel 'spatial frequency [cycles/mm]'; set ylabel 'one-sided profile PSD [nm² mm]'
set key inside left bottom vertical
plot 'ceilings.dat' using ($1*1e-3):($2*1e21) with linespoints linecolor rgb '#404040' linewidth 2 \
    dashtype 1 \
    pointtype 7 title 'one octave alone', \
  for [i=1:lines] level[i]*1e21*x**(-exponent[i]) with lines linecolor rgb colour[(i-1)%6+1] linewidth 2 \
    dashtype 1+(i-1)/6 title label[i]
