# title: Reflected rays
# caption: Above left, rays of the ideal mirror from its surface to the focus, seen from the side. The other
#   panels magnify the focus. The rays of the ideal mirror meet in a point; those of Harvey-Shack and of the
#   aberration terms spread over a spot.
# alt: Side views of reflected rays, whole and near the focus, for ideal mirror, Harvey-Shack and aberration
#   terms.
# format: svg
name = ARG0[1:strlen(ARG0)-3]; width = 1400; height = 1050
load 'common.gp'

set multiplot layout 2,2 title head('Reflected rays') font ',16'
unset key
set title sprintf('%d rays of the ideal mirror, focus at z = %.9g m', rays, focal_length)
set xlabel 'z [m]'; set ylabel axis('x', x_unit)
plot 'reflected_rays_fan.dat' using 1:($2*x_scale) with lines linetype 2 linewidth 0.7
do for [k=1:3] {
  set title label[k].', near the focus'
  set xlabel axis('distance from z = f', z_unit[k]); set ylabel axis('x', w_unit[k])
  set xrange [-reach[k]*z_scale[k]:reach[k]*z_scale[k]]
  plot 'reflected_rays_'.key[k].'.dat' using ($1*z_scale[k]):($2*w_scale[k]) with lines linetype 2 \
      linewidth 0.7
}
unset multiplot
