// gmsh -2 -format msh22 lip.geo
// the section of a sealing lip: a cone of 0.4 mm, whose edge at z = 0 touches the shaft
Point(1) = {20, 0, 0, 0.001}; Point(2) = {20.4, 0, 0, 0.15}; Point(3) = {21.2, 8, 0, 0.2}; Point(4) = {20.8, 8, 0, 0.2};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
Physical Curve("root") = {3}; Physical Curve("inside") = {4}; Physical Surface("lip") = {1};
