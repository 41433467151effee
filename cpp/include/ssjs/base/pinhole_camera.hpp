/// The camera that is left once a lens is corrected.
#pragma once

namespace ssjs {

/// Columns u to the right, rows v downwards, the centre of the top left pixel is (0, 0). Of a point (x, y, z) in the camera frame (x along
/// the columns, y along the rows, z ahead) it shows u = focal_x_px x / z + centre_x_px, v = focal_y_px y / z + centre_y_px. (V-1)
struct PinholeCamera {
  int width_px = 0;
  int height_px = 0;
  double focal_x_px = 0.0;
  double focal_y_px = 0.0;
  double centre_x_px = 0.0;
  double centre_y_px = 0.0;
};

}  // namespace ssjs
