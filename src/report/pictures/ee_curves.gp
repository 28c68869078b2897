# title: Encircled energy
# caption: Fraction of the energy within a radius of the centre, in the plane z = f. Vertical lines mark the
#   radii that hold 50 % and 90 % of it; circles are the values that the terms were fitted to. The lower panel
#   shows fitted minus target.
# alt: Encircled energy over radius for the ideal mirror, the target and the fitted surface, and the
#   difference of the last two.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1200; height = 950
load 'common.gp'

set xrange [0:last*r_scale]
set lmargin 11; set rmargin 3
set multiplot title head('Encircled energy at z = f') font ',16'
set size 1,(has_target ? 0.63 : 0.95); set origin 0,(has_target ? 0.32 : 0)
if (has_target) { set format x '' } else { set xlabel axis('radius', r_unit) }
set ylabel 'encircled energy'
set yrange [0:1.05]; set ytics 0.1
set key maxcols 2
do for [k=2:3] {
  if (ee50[k] == ee50[k]) {
    set arrow from ee50[k]*r_scale,0 to ee50[k]*r_scale,0.5 nohead linetype k linewidth 0.8
    set arrow from ee90[k]*r_scale,0 to ee90[k]*r_scale,0.9 nohead linetype k linewidth 0.8
  }
}
plot for [k in curves] 'ee_curves.dat' using ($1*r_scale):(column(k+1)) with lines linetype (k+0) \
    title label[k+0], \
  for [i=1:asked] 'ee_targets.dat' using ($1*r_scale):2 with points pointtype 6 pointsize 1.4 linewidth 1.5 \
    linecolor rgb 'black' title 'values fitted to'

if (has_target) {
  unset arrow
  set size 1,0.34; set origin 0,0
  set format x '%g'; set xlabel axis('radius', r_unit)
  set ylabel 'difference [% of energy]'
  set autoscale y; set ytics difference_step
  plot for [i=1:counted] 'ee_curves.dat' using ($1*r_scale):(-100*$5):(100*$5) with filledcurves \
      fillcolor rgb '#cfe3f2' title 'sampling error of the target, 1 sigma', \
    0 with lines dashtype 1 linecolor rgb ideal_colour linewidth 1 notitle, \
    'ee_curves.dat' using ($1*r_scale):(100*($4-$3)) with lines linetype 3 linewidth 2 title 'fitted - target'
}
unset multiplot
