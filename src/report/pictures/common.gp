# Settings of all pictures: a script sets `name`, `width` and `height` [pixels] and loads this file, which
# loads NAME.values. Another format: gnuplot -e "format='pdf'" NAME.gp, one of png, svg, pdf.
load name.'.values'
set encoding utf8
if (format eq 'svg') {
  set terminal svg name name noenhanced size width,height font 'sans-serif,17' linewidth 1.5 \
    background 'white'
} else { if (format eq 'pdf') {
  set terminal pdfcairo noenhanced size width/110.0,height/110.0 font 'DejaVu Sans,11' linewidth 1.2
} else {
  set terminal pngcairo noenhanced size width,height font 'DejaVu Sans,14' linewidth 1.5 \
    background rgb 'white'
} }
set output name.'.'.format

# The title of a picture: `text` and the title of the study, cut to the width.
whole_title(text) = strlen(study) ? text.' - '.study : text
most = width / 11
head(text) = strlen(whole_title(text)) > most ? whole_title(text)[1:most].'...' : whole_title(text)
axis(what, unit) = what.' ['.unit.']'

# Colours that everyone tells apart (Okabe & Ito 2008).
ideal_colour = '#666666'; target_colour = '#0072B2'; fitted_colour = '#D55E00'; good_colour = '#009E73'
array colour[7] = ['#0072B2', '#D55E00', '#009E73', '#CC79A7', '#E69F00', '#56B4E9', '#000000']
signed_palette = "set palette defined (-1 '#053061', -0.75 '#2166ac', -0.5 '#4393c3', -0.25 '#b0d2e6', \
  0 '#f7f7f7', 0.25 '#f6bfa6', 0.5 '#d6604d', 0.75 '#b2182b', 1 '#67001f')"
light_palette = "set palette defined (0 '#000004', 1 '#1b0c41', 2 '#4a0c6b', 3 '#781c6d', 4 '#a52c60', \
  5 '#cf4446', 6 '#ed6925', 7 '#fb9b06', 8 '#f7d13d', 9 '#fcffa4')"
value_palette = "set palette defined (0 '#fde725', 0.25 '#5ec962', 0.5 '#21918c', 0.75 '#3b528b', \
  1 '#440154')"

# These are the axes of a matrix with points x_first + k*x_pitch [m], and likewise in y. `matrix using 1:2:3
# axes x2y2` then needs no expression per point, which would take gnuplot three times as long.
pixel_axes = "set link x2 via (x/x_scale - x_first)/x_pitch inverse (x*x_pitch + x_first)*x_scale; \
  set link y2 via (y/x_scale - y_first)/y_pitch inverse (y*y_pitch + y_first)*x_scale"

# Line types 1, 2 and 3 are ideal mirror, target and fitted surface.
set linetype 1 linecolor rgb ideal_colour linewidth 2 dashtype 3
set linetype 2 linecolor rgb target_colour linewidth 2.5 dashtype 1
set linetype 3 linecolor rgb fitted_colour linewidth 2.5 dashtype (12,5)
set border linewidth 1.2
set tics nomirror
set grid linecolor rgb '#dddddd' linetype 1 linewidth 0.7
set key tmargin center horizontal Left reverse
set samples 181
