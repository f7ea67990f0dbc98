// for n in 1 2 3; do gmsh -3 -format msh22 -setnumber n $n chain.geo -o chain_$n.msh; done
// the upper half of a chain of round wire (radius w, bends of radius R about the wire's middle): half a link, a link upright, half a link
w = 2; R = 5; s = 1; h = 2.4; f = 0.4;
DefineConstant[ n = 1 ];
If (n == 1)
  Point(1) = {R, 0, 0, h}; Point(2) = {R + w, 0, 0, h}; Point(3) = {R, 0, w, h}; Point(4) = {R - w, 0, 0, f};
  Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Line(3) = {4, 1}; Line(4) = {1, 2};
  Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
  a[] = Extrude {{0, 0, 1}, {0, 0, 0}, Pi/2} { Surface{1}; };
  b[] = Extrude {-s, 0, 0} { Surface{a[0]}; };
  c[] = Extrude {{0, 0, 1}, {0, 0, 0}, -Pi/2} { Surface{1}; };
  d[] = Extrude {-s, 0, 0} { Surface{c[0]}; };
  Physical Volume("link") = {a[1], b[1], c[1], d[1]}; Physical Surface("held") = {b[0], d[0]}; Physical Surface("bend") = {a[2], a[3], c[2], c[3]};
  Physical Surface("middle") = {a[4], a[5], b[4], b[5], c[4], c[5], d[4], d[5]};
EndIf
If (n == 2)
  Point(1) = {1, 0, 0, h}; Point(2) = {1 - w, 0, 0, h}; Point(3) = {1, w, 0, h}; Point(4) = {1 + w, 0, 0, f}; Point(5) = {1, -w, 0, h};
  Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Circle(3) = {4, 1, 5}; Circle(4) = {5, 1, 2};
  Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
  a[] = Extrude {{0, 1, 0}, {1 + R, 0, 0}, Pi/2} { Surface{1}; };
  b[] = Extrude {2 * s, 0, 0} { Surface{a[0]}; };
  c[] = Extrude {{0, 1, 0}, {1 + R + 2 * s, 0, 0}, Pi/2} { Surface{b[0]}; };
  Physical Volume("link") = {a[1], b[1], c[1]}; Physical Surface("left bend") = {a[2], a[3], a[4], a[5]};
  Physical Surface("right bend") = {c[2], c[3], c[4], c[5]}; Physical Surface("middle") = {1, c[0]};
EndIf
If (n == 3)
  x = 2 + R + 2 * s;
  Point(1) = {x, 0, 0, h}; Point(2) = {x - w, 0, 0, h}; Point(3) = {x, 0, w, h}; Point(4) = {x + w, 0, 0, f};
  Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Line(3) = {4, 1}; Line(4) = {1, 2};
  Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
  a[] = Extrude {{0, 0, 1}, {x + R, 0, 0}, -Pi/2} { Surface{1}; };
  b[] = Extrude {s, 0, 0} { Surface{a[0]}; };
  c[] = Extrude {{0, 0, 1}, {x + R, 0, 0}, Pi/2} { Surface{1}; };
  d[] = Extrude {s, 0, 0} { Surface{c[0]}; };
  Physical Volume("link") = {a[1], b[1], c[1], d[1]}; Physical Surface("bend") = {a[2], a[3], c[2], c[3]};
  Physical Surface("middle") = {a[4], a[5], b[4], b[5], c[4], c[5], d[4], d[5]};
EndIf
