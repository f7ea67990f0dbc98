// gmsh -2 -format msh22 hook.geo
// a cantilever hook: an arm of 20 mm by 2 mm, and a round nose of radius 1 mm, which rises by 1 mm at x = 18.4
f = 0.012;
Point(1) = {0, 0, 0, 0.5}; Point(2) = {20, 0, 0, 0.5}; Point(3) = {20, 2, 0, 0.4}; Point(4) = {19.4, 2, 0, 0.15}; Point(5) = {18.4, 2, 0, 0.3};
Point(6) = {18.4 - Sin(0.11), 2 + Cos(0.11), 0, f}; Point(7) = {18.4 - Sin(0.05), 2 + Cos(0.05), 0, f}; Point(8) = {17.4, 2, 0, 0.15}; Point(9) = {0, 2, 0, 0.5};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Circle(4) = {4, 5, 7}; Circle(5) = {7, 5, 6}; Circle(6) = {6, 5, 8}; Line(7) = {8, 9}; Line(8) = {9, 1};
Curve Loop(1) = {1:8}; Plane Surface(1) = {1};
Physical Curve("root") = {8}; Physical Curve("nose") = {4, 5, 6}; Physical Surface("hook") = {1};
