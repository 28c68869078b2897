# title: Energy through a ring
# caption: Fraction of the energy inside one ring about the axis, plane by plane along the axis. The radius of
#   the ring holds 90 % of the target's energy at z = f. The full width at half maximum is a depth of focus.
# alt: Fraction of the energy inside a ring over the distance from z = f, for ideal mirror, target and fitted
#   surface.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 800
load 'common.gp'

set multiplot title head('Energy through a ring') font ',16'
set size 1,0.94; set origin 0,0
set xlabel axis('plane: distance from z = f along the axis', z_unit)
set ylabel 'fraction of the energy inside a ring of radius '.ring
set xrange [-last*z_scale:last*z_scale]; set yrange [0:1.05]; set ytics 0.1
set key maxcols 2
plot for [k in curves] 'ring_through.dat' using ($1*z_scale):(column(k+1)) with lines linetype (k+0) \
    title label[k+0], \
  half_maximum with lines linecolor rgb '#999999' linewidth 0.8 dashtype 1 title \
      'half maximum of the '.reference
unset multiplot
