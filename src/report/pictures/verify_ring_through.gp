# title: Rays through a ring
# caption: Fraction of the rays inside a ring, plane by plane along the axis. The ring of each case holds 90 %
#   of its rays at z = f. Harvey-Shack and terms should agree in the full width at half maximum.
# alt: Fraction of rays inside a ring over the distance from z = f, three panels.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1100; height = 1200
load 'common.gp'

set multiplot layout 3,1 title head('Rays through a ring, half maximum dotted') font ',16'
unset key
set ylabel 'fraction inside the ring'; set yrange [0:1.05]
do for [k=1:3] {
  set title ring_title[k]
  set xlabel axis('distance from z = f', z_unit[k]); set xrange [-last[k]*z_scale[k]:last[k]*z_scale[k]]
  plot 'ring_through.dat' index k-1 using ($1*z_scale[k]):2 with lines linetype 2, \
    half_maximum[k] with lines linetype 1
}
unset multiplot
