// gmsh -2 -format msh22 cup.geo
// the half of a cup's section: its hollow of 25.1 mm about (0, 0.1) has its lowest point at (0, -25)
Point(1) = {0, 0.1, 0}; Point(2) = {0, -25, 0, 0.4}; Point(3) = {25.1, 0.1, 0, 2}; Point(4) = {60, 0.1, 0, 10}; Point(5) = {0, -59.9, 0, 10};
Circle(1) = {2, 1, 3}; Line(2) = {3, 4}; Circle(3) = {4, 1, 5}; Line(4) = {5, 2};
Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
Physical Curve("hollow") = {1}; Physical Curve("outside") = {3}; Physical Surface("cup") = {1};
