// gmsh -2 -format msh22 bolt.geo
// the half of a bolt's section: a shank from its held end at z = 0 to its head at z = 60
Point(1) = {0, 0, 0, 2.5}; Point(2) = {5, 0, 0, 2.5}; Point(3) = {5, 60, 0, 0.6}; Point(4) = {9, 60, 0, 0.6};
Point(5) = {9, 68, 0, 2}; Point(6) = {0, 68, 0, 2};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 6}; Line(6) = {6, 1};
Curve Loop(1) = {1:6}; Plane Surface(1) = {1};
Physical Curve("end") = {1}; Physical Curve("seat") = {3}; Physical Curve("top") = {5}; Physical Surface("bolt") = {1};
