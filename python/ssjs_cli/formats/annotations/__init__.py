"""Where the objects of images are, as people write it down.

| form | told by | boxes |
|---|---|---|
| OpenCV's `info.dat` | a file, .dat, .txt or .info | `path n x y w h ...` a line, first pixel (0, 0) |
| YOLO | a folder of .txt | `class x y w h` a line: centre and size as parts of the picture's |
| Pascal VOC | an .xml file or a folder of them | `<bndbox>` xmin ymin xmax ymax, first pixel (1, 1), the last one inside the box |
| COCO | a .json file | `bbox` [x, y, w, h], first pixel at (0, 0) |
| table | a .csv file | columns image, x_px, y_px, width_px, height_px, and optionally label |

Inside the program a box is left, top, width, height in whole pixels, the first pixel at (0, 0).
"""
