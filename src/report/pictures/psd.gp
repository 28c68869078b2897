# title: PSD of the measurement
# caption: Power spectral density of the measured surface in bins with confidence intervals, and the fitted
#   model. Spectral lines, such as turning marks, are left out of the fit and marked by dashed lines.
# alt: Measured PSD with intervals and fitted model over spatial frequency.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 800
load 'common.gp'

set title head(is_profile ? 'PSD of the profile' : 'PSD of the surface')
eval x_axis; eval y_axis
set xlabel 'spatial frequency [cycles/mm]'
set ylabel is_profile ? 'one-sided PSD [nm² mm]' : 'two-sided 2-D PSD [nm² mm²]'
do for [k=1:lines] {
  set arrow from first 1e-3*line[k], graph 0 to first 1e-3*line[k], graph 1 nohead \
    linecolor rgb colour[4] dashtype 2
}
plot 'psd.dat' using ($1*1e-3):($2*scale):($3*scale):($4*scale) with yerrorbars pointtype 7 pointsize 0.8 \
    linecolor rgb target_colour linewidth 1.2 dashtype 1 title sprintf('estimate, %.4g %% intervals', \
        confidence), \
  '' using ($1*1e-3):($5*scale) with lines linetype 3 dashtype 1 title 'model: '.model, \
  for [i=1:lines > 0] NaN with lines linecolor rgb colour[4] dashtype 2 title 'spectral lines, left out'
