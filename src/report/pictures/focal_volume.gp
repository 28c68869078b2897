# title: Focal volume
# caption: Irradiance along x in planes through the focus, by rays; colours show its square root. The waist is
#   a point for the ideal mirror. For Harvey-Shack and terms the scatter sets its width and depth.
# alt: Irradiance over x and distance from the focus for ideal mirror, Harvey-Shack and aberration terms.
# format: png
name = ARG0[1:strlen(ARG0)-3]; width = 1100; height = 1300
load 'common.gp'

set multiplot layout 3,1 title head('Focal volume, colour: root of the irradiance') font ',16'
unset key; unset grid; unset colorbox
set tics out; set cbrange [0:1]
eval light_palette
do for [k=1:3] {
  far = last[k]*z_scale[k]; edge = half[k]*x_scale[k]
  set title label[k]
  set xlabel axis('distance from z = f', z_unit[k]); set ylabel axis('x', x_unit[k])
  set xrange [-far:far]; set yrange [-edge:edge]
  plot 'focal_volume_'.key[k].'.dat' matrix \
    using (far*(2.0*$1/(planes-1) - 1)):(edge*((2.0*$2+1)/pixels - 1)):(sqrt($3/brightest[k])) with image
}
unset multiplot
