# title: Focal images
# caption: Spots by rays before, at and behind the focus. Colours show the square root of the irradiance, each
#   image with its own scale. Harvey-Shack and the aberration terms should agree in size and fall-off,
#   although one realisation of terms is never round.
# alt: Images of the spots of ideal mirror, Harvey-Shack and aberration terms in three planes.
# format: png
name = ARG0[1:strlen(ARG0)-3]; width = 1400; height = 1450
load 'common.gp'

set multiplot layout 3,3 title head('Focal images by rays, colour: root of the irradiance') font ',16'
unset key; unset grid; unset colorbox
set size ratio -1; set tics out; set cbrange [0:1]
eval light_palette
do for [row=1:3] {
  edge = half[row]*x_scale[row]
  pixel = 2*edge/pixels
  set xrange [-edge:edge]; set yrange [-edge:edge]
  set xlabel axis('x', x_unit[row]); set ylabel axis('y', x_unit[row])
  do for [column=1:3] {
    k = 3*(row-1) + column
    set title plane[k] font ',12'
    plot sprintf('focal_images_%s_%d.dat', key[row], column) matrix \
      using (($1+0.5)*pixel - edge):(($2+0.5)*pixel - edge):(sqrt($3/brightest[k])) with image
  }
}
unset multiplot
