# title: Measured profile
# caption: Measured heights after detrending, as the PSD is estimated from them. Steps and spikes distort a
#   PSD.
# alt: Detrended height over position along the measured profile.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 600
load 'common.gp'

set title head('Measured profile, detrended')
set xlabel axis('x', x_unit); set ylabel axis('height', h_unit)
unset key
plot name.'.dat' using ($1*x_scale):($2*h_scale) with lines linecolor rgb target_colour linewidth 1.5 \
    dashtype 1
